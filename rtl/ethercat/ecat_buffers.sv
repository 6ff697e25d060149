// SPDX-License-Identifier: Apache-2.0
// ecat_buffers: the area of a sync manager: whether it is open, which of three buffers its writer and its reader have, or
// whether its mailbox is full.
// Contract: an access is of a frame as it passes (passing_i: reads, but writes only ask), of what a good frame left
// (commit_i), or of the application. The first byte opens the area for its side until the last byte; begun_o says of the present
// access whether it is open, and one that is not has no consequences. reads_i and writes_i: the access is by the side that
// reads or writes, and the mailbox lets it. What a passing frame asks to write opens the area for this frame only. writer_o
// and reader_o are never the same of the three. The reader's first byte gives it the newest complete buffer, of a frame's
// reads once a frame: reader_o shows it at once. A buffer (or mailbox) is complete three clocks after its last byte, when
// that is in the memory; until then the reader gets the one before, so a reader at a fixed time after the writer gets new
// bytes each time. A writer begins again three clocks after its last byte or later. Mode and direction change while clear_i
// only; then everything begins again.
// written_o and read_o are the events of reader and writer. The application's first byte ends an event, as in the ESCs of
// Beckhoff (ET1100 Hardware Data Sheet, register 0x0805), a frame's last byte does when it commits. A complete buffer that
// the reader has not opened keeps its event.
module ecat_buffers (
    input  logic       clk_i,
    input  logic       rst_ni,
    input  logic       clear_i,
    input  logic       mailbox_i,
    input  logic       frame_start_i,
    // an access to the area
    input  logic       passing_i,
    input  logic       commit_i,
    input  logic       reads_i,
    input  logic       writes_i,
    input  logic       first_i,    // byte
    input  logic       ends_i,     // last byte
    output logic       begun_o,
    output logic       is_written_o,  // to its end
    // state
    output logic [1:0] writer_o,
    output logic [1:0] reader_o,
    output logic [1:0] last_o,     // written last, 3: none since clear_i
    output logic       full_o,     // mailbox
    output logic       written_o,
    output logic       read_o
);

  logic [1:0] writer_q, reader_q, middle_q, last_q;
  logic [1:0] settle_q;  // the last byte was written one clock before, two
  logic new_q, full_q, written_q, read_q, takes;
  logic passing_q, committed_q, application_q, opened_q;  // opened_q: by this frame
  logic reads, writes, begun, opens, is_written, is_read, done, committed;

  assign begun      = first_i || (passing_i ? passing_q : commit_i ? committed_q : application_q);
  assign reads      = reads_i && begun;
  assign writes     = writes_i && begun;
  assign opens      = reads && first_i && !commit_i && !(passing_i && opened_q);
  assign is_written = writes && ends_i && !passing_i;
  assign is_read    = reads && ends_i && !passing_i;
  assign takes      = opens && new_q && !mailbox_i;
  assign done       = !passing_i && (reads ? (commit_i ? ends_i && (mailbox_i || !new_q) : first_i)
                                           : writes && (commit_i ? ends_i : first_i));

  // What a frame reads opens as it passes, since the buffer is the reader's then; what it writes, by its commit.
  assign committed = commit_i && writes ? !ends_i
                     : committed_q ? !(commit_i && is_read) : passing_i && reads && first_i;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      passing_q     <= 1'b0;
      committed_q   <= 1'b0;
      application_q <= 1'b0;
      opened_q      <= 1'b0;
    end else if (clear_i) begin
      passing_q     <= 1'b0;
      committed_q   <= 1'b0;
      application_q <= 1'b0;
      opened_q      <= 1'b0;
    end else begin
      committed_q <= committed;
      if (frame_start_i || commit_i) passing_q <= committed;
      else if (passing_i && (reads || writes)) passing_q <= !ends_i;
      if (!passing_i && !commit_i && (reads || writes)) application_q <= !ends_i;
      if (frame_start_i) opened_q <= 1'b0;
      else if (passing_i && opens) opened_q <= 1'b1;
    end
  end

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
      settle_q  <= '0;
    end else if (clear_i) begin
      writer_q  <= 2'd0;
      middle_q  <= 2'd1;
      reader_q  <= 2'd2;
      last_q    <= 2'd3;
      new_q     <= 1'b0;
      full_q    <= 1'b0;
      written_q <= 1'b0;
      read_q    <= 1'b0;
      settle_q  <= '0;
    end else begin
      settle_q <= {settle_q[0], is_written};
      if (settle_q[1] && !mailbox_i) begin  // the writer gets what the reader does not have
        writer_q <= takes ? reader_q : middle_q;
        middle_q <= writer_q;
        new_q    <= 1'b1;
        last_q   <= writer_q;
      end else if (takes) begin
        middle_q <= reader_q;
        new_q    <= 1'b0;
      end
      if (takes) reader_q <= middle_q;
      if (settle_q[1]) full_q <= 1'b1;
      else if (is_read) full_q <= 1'b0;
      if (settle_q[1]) written_q <= 1'b1;
      else if (done && reads) written_q <= 1'b0;
      if (is_read) read_q <= 1'b1;
      else if (done && writes) read_q <= 1'b0;
    end
  end

  assign begun_o      = begun;
  assign is_written_o = is_written;
  assign writer_o  = mailbox_i ? 2'd0 : writer_q;
  assign reader_o  = mailbox_i ? 2'd0 : takes ? middle_q : reader_q;
  assign last_o    = last_q;
  assign full_o    = full_q && mailbox_i;
  assign written_o = written_q;
  assign read_o    = read_q;

endmodule
