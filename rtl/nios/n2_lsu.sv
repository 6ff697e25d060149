// SPDX-License-Identifier: Apache-2.0
// n2_lsu: loads and stores. Address in E, memory in M, alignment in A; Avalon transfers hold A.
// Contract: live_e_i is low for an instruction that will not complete. An address in neither tightly
// coupled memory makes an Avalon transfer: request in the first cycle of A, answer registered, so A is held
// for 1 cycle plus the wait states. Misaligned addresses write no memory. data_a_o is the loaded
// value while the load is in A and not held. A store to a memory waits in a buffer of one word and is
// written in the next cycle in which the pipeline moves and E has no load; loads see the buffer.
module n2_lsu #(
    parameter logic [31:0] ItcmBase = 32'h1000_0000,
    parameter int unsigned ItcmBytes = 65536,
    parameter logic [31:0] DtcmBase = 32'h1004_0000,
    parameter int unsigned DtcmBytes = 65536
) (
    input  logic                         clk_i,
    input  logic                         rst_ni,
    input  logic                         en_i,
    // E
    input  logic                         live_e_i,
    input  logic                         load_e_i,
    input  logic                         store_e_i,
    input  logic [1:0]                   size_e_i,
    input  logic                         signed_e_i,
    input  logic [31:0]                  base_e_i,
    input  logic [15:0]                  offset_e_i,
    input  logic [31:0]                  data_e_i,
    output logic                         misaligned_e_o,
    output logic [29:0]                  word_e_o,       // address of the word
    output logic [3:0]                   lanes_e_o,
    // M and A
    output logic [31:0]                  address_m_o,
    output logic                         wait_a_o,
    output logic [31:0]                  data_a_o,
    // to the memories
    output logic                         itcm_en_o,
    output logic [3:0]                   itcm_we_o,
    output logic [$clog2(ItcmBytes)-3:0] itcm_address_o,
    output logic [31:0]                  itcm_wdata_o,
    input  logic [31:0]                  itcm_rdata_i,
    output logic                         dtcm_en_o,
    output logic [3:0]                   dtcm_we_o,
    output logic [$clog2(DtcmBytes)-3:0] dtcm_address_o,
    output logic [31:0]                  dtcm_wdata_o,
    input  logic [31:0]                  dtcm_rdata_i,
    // Avalon-MM data master
    output logic [31:0]                  avm_address_o,
    output logic                         avm_read_o,
    output logic                         avm_write_o,
    output logic [3:0]                   avm_byteenable_o,
    output logic [31:0]                  avm_writedata_o,
    input  logic [31:0]                  avm_readdata_i,
    input  logic                         avm_waitrequest_i
);

  localparam int unsigned ItcmBits = $clog2(ItcmBytes);
  localparam int unsigned DtcmBits = $clog2(DtcmBytes);

  localparam int unsigned BufferBits = ItcmBits > DtcmBits ? ItcmBits : DtcmBits;

  logic [31:0] address, wdata, address_m_q, wdata_m_q;
  logic [3:0] lanes, lanes_m_q;
  logic in_itcm, in_dtcm, access, write;
  logic itcm_m_q, dtcm_m_q, load_m_q, store_m_q;  // load and store: Avalon only
  // The buffer: at most one of the first two is high.
  logic buffer_itcm_q, buffer_dtcm_q;
  logic [BufferBits-1:2] buffer_address_q;
  logic [31:0] buffer_wdata_q;
  logic [3:0] buffer_lanes_q, forward_m, from_itcm, from_dtcm;
  logic same_m;
  logic signed_m_q, signed_a_q;
  logic [1:0] size_m_q, size_a_q, byte_a_q;
  logic busy_q, read_q, write_q;
  logic [31:0] early, raw, raw_a_q, avm_address_q, avm_writedata_q;
  logic [3:0] avm_byteenable_q;

  // Stage E.
  assign address = base_e_i + {{16{offset_e_i[15]}}, offset_e_i};
  n2_region #(
      .Base(ItcmBase),
      .Bits(ItcmBits)
  ) u_in_itcm (
      .base_i  (base_e_i),
      .offset_i(offset_e_i),
      .inside_o(in_itcm)
  );
  n2_region #(
      .Base(DtcmBase),
      .Bits(DtcmBits)
  ) u_in_dtcm (
      .base_i  (base_e_i),
      .offset_i(offset_e_i),
      .inside_o(in_dtcm)
  );
  assign misaligned_e_o = (load_e_i || store_e_i) &&
                          ((size_e_i[0] && address[0]) || (size_e_i[1] && address[1:0] != 2'd0));
  assign word_e_o  = address[31:2];
  assign lanes_e_o = lanes;
  assign access = live_e_i && (load_e_i || store_e_i);
  assign write  = live_e_i && store_e_i && !misaligned_e_o;

  always_comb begin
    case (size_e_i)
      2'd0: begin
        lanes = 4'b0001 << address[1:0];
        wdata = {4{data_e_i[7:0]}};
      end
      2'd1: begin
        lanes = address[1] ? 4'b1100 : 4'b0011;
        wdata = {2{data_e_i[15:0]}};
      end
      default: begin
        lanes = 4'b1111;
        wdata = data_e_i;
      end
    endcase
  end

  // The address of a load is used in E; the memories' ports are free for the buffer in every other
  // cycle. So the buffer is empty, or emptied at this edge, when E has a store, and nothing waits.
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      buffer_itcm_q <= 1'b0;
      buffer_dtcm_q <= 1'b0;
    end else if (en_i && !load_e_i) begin
      buffer_itcm_q <= write && in_itcm;
      buffer_dtcm_q <= write && in_dtcm;
    end
  end

  always_ff @(posedge clk_i) begin
    if (en_i && !load_e_i) begin
      buffer_address_q <= address[BufferBits-1:2];
      buffer_wdata_q   <= wdata;
      buffer_lanes_q   <= lanes;
    end
  end

  assign itcm_en_o      = en_i && (load_e_i || buffer_itcm_q);
  assign itcm_we_o      = {4{buffer_itcm_q && !load_e_i}} & buffer_lanes_q;
  assign itcm_address_o = load_e_i ? address[ItcmBits-1:2] : buffer_address_q[ItcmBits-1:2];
  assign itcm_wdata_o   = buffer_wdata_q;
  assign dtcm_en_o      = en_i && (load_e_i || buffer_dtcm_q);
  assign dtcm_we_o      = {4{buffer_dtcm_q && !load_e_i}} & buffer_lanes_q;
  assign dtcm_address_o = load_e_i ? address[DtcmBits-1:2] : buffer_address_q[DtcmBits-1:2];
  assign dtcm_wdata_o   = buffer_wdata_q;

  // The buffer did not change when the load went from E to M, so its bytes are compared in M.
  assign same_m = address_m_q[BufferBits-1:2] == buffer_address_q;
  assign forward_m = {4{same_m && ((itcm_m_q && buffer_itcm_q) || (dtcm_m_q && buffer_dtcm_q))}} &
                     buffer_lanes_q;

  // What the memories give comes last, so that one gate follows it.
  always_comb begin
    for (int unsigned i = 0; i < 4; i++) begin
      from_itcm[i] = en_i && itcm_m_q && !forward_m[i];
      from_dtcm[i] = en_i && !itcm_m_q && !forward_m[i];
      early[8*i+:8] = !en_i ? avm_readdata_i[8*i+:8] : buffer_wdata_q[8*i+:8] & {8{forward_m[i]}};
      raw[8*i+:8] = ({8{from_itcm[i]}} & itcm_rdata_i[8*i+:8]) |
                    ({8{from_dtcm[i]}} & dtcm_rdata_i[8*i+:8]) | early[8*i+:8];
    end
  end

  // Stages M and A: the request of an Avalon transfer goes up as the instruction enters A.
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      load_m_q  <= 1'b0;
      store_m_q <= 1'b0;
      busy_q    <= 1'b0;
      read_q    <= 1'b0;
      write_q   <= 1'b0;
    end else if (en_i) begin
      load_m_q  <= access && load_e_i && !misaligned_e_o && !in_itcm && !in_dtcm;
      store_m_q <= write && !in_itcm && !in_dtcm;
      busy_q    <= load_m_q || store_m_q;
      read_q    <= load_m_q;
      write_q   <= store_m_q;
    end else if (!avm_waitrequest_i) begin
      busy_q  <= 1'b0;
      read_q  <= 1'b0;
      write_q <= 1'b0;
    end
  end

  always_ff @(posedge clk_i) begin
    if (en_i) begin
      address_m_q      <= address;
      wdata_m_q        <= wdata;
      lanes_m_q        <= lanes;
      size_m_q         <= size_e_i;
      signed_m_q       <= signed_e_i;
      itcm_m_q         <= in_itcm;
      dtcm_m_q         <= in_dtcm;
      avm_address_q    <= {address_m_q[31:2], 2'd0};
      avm_writedata_q  <= wdata_m_q;
      avm_byteenable_q <= lanes_m_q;
      size_a_q         <= size_m_q;
      signed_a_q       <= signed_m_q;
      byte_a_q         <= address_m_q[1:0];
    end
    if (en_i || read_q) raw_a_q <= raw;
  end

  assign address_m_o      = address_m_q;
  assign wait_a_o         = busy_q;
  assign avm_address_o    = avm_address_q;
  assign avm_read_o       = read_q;
  assign avm_write_o      = write_q;
  assign avm_byteenable_o = avm_byteenable_q;
  assign avm_writedata_o  = avm_writedata_q;

  // Stage A: the addressed bytes go to the bottom and are extended.
  logic [7:0] low_byte;
  logic [15:0] half;
  logic fill;
  always_comb begin
    half = byte_a_q[1] ? raw_a_q[31:16] : raw_a_q[15:0];
    low_byte = byte_a_q[0] && size_a_q == 2'd0 ? half[15:8] : half[7:0];
    fill = signed_a_q && (size_a_q[0] ? half[15] : low_byte[7]);
    if (size_a_q[1]) data_a_o = raw_a_q;
    else if (size_a_q[0]) data_a_o = {{16{fill}}, half};
    else data_a_o = {{24{fill}}, low_byte};
  end

endmodule
