// SPDX-License-Identifier: Apache-2.0
// asip_memory: data memory of the ASIP with its address unit.
// Contract: address = int32(index) + imm in stage E1; a load's result is registered 3 ranks later, a
// store is visible to every later load. fault_e2_o: the address is outside the memory; nothing is
// read or written then. The host uses the same port while the core is idle.
module asip_memory #(
    parameter int unsigned Words = 1024
) (
    input  logic        clk_i,
    input  logic        rst_ni,
    // from the operand stage, E1
    input  logic        load_i,
    input  logic        store_i,
    input  logic [31:0] index_i,
    input  logic [15:0] imm_i,
    input  logic [31:0] data_i,
    output logic        fault_e2_o,
    // to write-back
    output logic        valid_o,
    output logic [31:0] result_o,
    // from and to the host, idle only; a read takes 3 cycles
    input  logic        host_write_i,
    input  logic [15:0] host_address_i,
    input  logic [31:0] host_data_i,
    input  logic        host_select_i,
    output logic [31:0] host_read_o
);

  localparam int unsigned AddressWidth = $clog2(Words);

  logic [16:0] address_e1;  // without the upper half of the index
  logic [AddressWidth-1:0] address_e2_q;
  logic [31:0] data_e2_q, read_e3, result_q;
  logic host_write_q, load_e2_q, store_e2_q, load_e3_q, valid_q;
  logic zeros_e2_q, ones_e2_q, carry_e2_q, above_e2_q;  // of the sum's upper bits
  logic inside_e2, write_e2, host_inside;

  // The upper half of the sum is zero if that of the index is, or becomes so with the carry.
  assign address_e1  = {1'b0, index_i[15:0]} + {1'b0, imm_i};
  assign inside_e2   = (carry_e2_q ? ones_e2_q : zeros_e2_q) && !above_e2_q;
  assign write_e2    = host_write_q || (store_e2_q && inside_e2);
  assign fault_e2_o  = (load_e2_q || store_e2_q) && !inside_e2;
  assign host_inside = !(|host_address_i[15:AddressWidth]);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      host_write_q <= 1'b0;
      load_e2_q    <= 1'b0;
      store_e2_q   <= 1'b0;
      load_e3_q    <= 1'b0;
      valid_q      <= 1'b0;
    end else begin
      host_write_q <= host_select_i && host_write_i && host_inside;
      load_e2_q    <= load_i;
      store_e2_q   <= store_i && !host_select_i;
      load_e3_q    <= load_e2_q && inside_e2;
      valid_q      <= load_e3_q;
    end
  end

  always_ff @(posedge clk_i) begin
    zeros_e2_q   <= !(|index_i[31:16]);
    ones_e2_q    <= &index_i[31:16];
    carry_e2_q   <= address_e1[16];
    above_e2_q   <= |address_e1[15:AddressWidth];
    address_e2_q <= host_select_i ? host_address_i[AddressWidth-1:0] :
                    address_e1[AddressWidth-1:0];
    data_e2_q    <= host_select_i ? host_data_i : data_i;
    result_q     <= read_e3;
  end

  // Nobody uses what is read in the clock of a write.
  ram_block #(
      .Words(Words),
      .Width(32)
  ) u_ram (
      .clk_i,
      .write_i        (write_e2),
      .write_address_i(address_e2_q),
      .write_data_i   (data_e2_q),
      .read_i         (1'b1),
      .read_address_i (address_e2_q),
      .read_data_o    (read_e3)
  );

  assign valid_o     = valid_q;
  assign result_o    = result_q;
  assign host_read_o = host_inside ? result_q : 32'd0;

endmodule
