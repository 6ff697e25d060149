// SPDX-License-Identifier: Apache-2.0
// ecat_ports_sva: a loop changes only while no frame passes; nothing leaves by a closed port.
module ecat_ports_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic busy,
    input logic [1:0] open_q,
    input ecat_pkg::nibble_t send_0_o,
    input ecat_pkg::nibble_t send_1_o
);

  LoopStays : assert property (@(posedge clk_i) disable iff (!rst_ni) busy |=> $stable(open_q))
  else $error("a loop changed in a frame");

  ClosedIsSilent : assert property (@(posedge clk_i) disable iff (!rst_ni)
      !(send_0_o.valid && !open_q[0]) && !(send_1_o.valid && !open_q[1]))
  else $error("a frame leaves by a closed port");

endmodule

bind ecat_ports ecat_ports_sva u_sva (.*);
