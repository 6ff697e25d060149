// SPDX-License-Identifier: Apache-2.0
// ecat_buffers: which of three buffers the writer and the reader of a sync manager have, or whether its mailbox
// is full.
// Contract: writer_o and reader_o are never the same of the three. opens_i (the reader's first
// byte) gives the reader the newest complete buffer with the same clock: reader_o shows it at once; one is complete Settle
// clocks behind written_i, when its last byte is in the memory. written_i
// and read_i are the ends of an access. Everything begins anew while clear_i.
module ecat_buffers (
    input  logic       clk_i,
    input  logic       rst_ni,
    input  logic       clear_i,
    input  logic       mailbox_i,
    input  logic       opens_i,
    input  logic       written_i,
    input  logic       read_i,
    output logic [1:0] writer_o,
    output logic [1:0] reader_o,
    output logic [1:0] last_o,     // written last, 3: none since clear_i
    output logic       full_o,     // mailbox
    output logic       written_o,  // since the last read
    output logic       read_o      // since the last write
);

  logic [1:0] writer_q, reader_q, middle_q, last_q;
  localparam logic [2:0] Settle = 3'd4;

  logic [2:0] age_q;
  logic       new_q, full_q, written_q, read_q, takes;

  assign takes = opens_i && new_q && age_q == Settle && !mailbox_i;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      writer_q  <= 2'd0;
      middle_q  <= 2'd1;
      reader_q  <= 2'd2;
      last_q    <= 2'd3;
      new_q     <= 1'b0;
      full_q    <= 1'b0;
      written_q <= 1'b0;
      read_q    <= 1'b0;
      age_q     <= '0;
    end else if (clear_i) begin
      writer_q  <= 2'd0;
      middle_q  <= 2'd1;
      reader_q  <= 2'd2;
      last_q    <= 2'd3;
      new_q     <= 1'b0;
      full_q    <= 1'b0;
      written_q <= 1'b0;
      read_q    <= 1'b0;
    end else begin
      age_q <= written_i ? '0 : age_q == Settle ? Settle : age_q + 1'b1;
      if (written_i && !mailbox_i) begin  // the writer gets what the reader does not have now
        writer_q <= takes ? reader_q : middle_q;
        middle_q <= writer_q;
        if (takes) reader_q <= middle_q;
        new_q    <= 1'b1;
        last_q   <= writer_q;
      end else if (takes) begin
        reader_q <= middle_q;
        middle_q <= reader_q;
        new_q    <= 1'b0;
      end
      if (written_i) begin
        full_q    <= 1'b1;
        written_q <= 1'b1;
        read_q    <= 1'b0;
      end else if (read_i) begin
        full_q    <= 1'b0;
        written_q <= 1'b0;
        read_q    <= 1'b1;
      end
    end
  end

  assign writer_o  = mailbox_i ? 2'd0 : writer_q;
  assign reader_o  = mailbox_i ? 2'd0 : takes ? middle_q : reader_q;
  assign last_o    = last_q;
  assign full_o    = full_q && mailbox_i;
  assign written_o = written_q;
  assign read_o    = read_q;

endmodule
