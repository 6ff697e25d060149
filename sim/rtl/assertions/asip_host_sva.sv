// SPDX-License-Identifier: Apache-2.0
// asip_host_sva: a run is not disturbed: memories and its registers are written and read while idle only.
module asip_host_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic hold_i,
    input logic start_o,
    input logic clear_o,
    input logic write_i,
    input logic waitrequest_o,
    input logic write_constant_o,
    input logic write_safe_o,
    input logic write_register_o,
    input logic write_data_o,
    input logic write_program_o,
    input logic write_record_o,
    input logic select_o,
    input logic irq_o,
    input logic done_i,
    input logic fault_i
);

  OneTarget : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $onehot0({write_constant_o, write_safe_o, write_register_o, write_data_o, write_program_o,
                write_record_o, start_o || clear_o}))
  else $error("one word of the host was written in two places");

  MemoriesIdle : assert property (@(posedge clk_i) disable iff (!rst_ni)
      write_constant_o || write_safe_o || write_register_o || write_data_o || write_program_o ||
      write_record_o || select_o |-> !hold_i)
  else $error("a memory was accessed while accesses are held");

  WriteInOneCycle : assert property (@(posedge clk_i) disable iff (!rst_ni)
      write_i && !hold_i |-> !waitrequest_o)
  else $error("a write waited though nothing held it");

  WrittenWhenTaken : assert property (@(posedge clk_i) disable iff (!rst_ni)
      write_constant_o || write_safe_o || write_register_o || write_data_o || write_program_o ||
      write_record_o || start_o || clear_o |-> write_i && !waitrequest_o)
  else $error("a write that was held took effect");

  InterruptOfAnEvent : assert property (@(posedge clk_i) disable iff (!rst_ni)
      irq_o |-> done_i || fault_i)
  else $error("an interrupt without an event");

endmodule

bind asip_host asip_host_sva u_sva (.*);
