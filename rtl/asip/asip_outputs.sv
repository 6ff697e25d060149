// SPDX-License-Identifier: Apache-2.0
// asip_outputs: output words in three pages: two that runs fill in turn, one of safe values. A fourth holds the
// plausibility record, which asip_plausible reads from here as it reads both pages of outputs.
// Contract: a run writes the hidden page; commit_i shows it. From reset, and from a fault on, until the
// next commit the host reads the safe page. Reads take two cycles. A word is registered before it is
// stored and checked: not_finite_o comes, with its index, a cycle after write-back. No word is read in the cycle in
// which it is written, or what is read is not used.
module asip_outputs #(
    parameter int unsigned Resilience = 0  // 1: parity of the words, inverted copies of the pages
) (
    input  logic        clk_i,
    input  logic        rst_ni,
    // from control
    input  logic        commit_i,
    input  logic        fault_i,
    // from write-back
    input  logic        write_i,
    input  logic [4:0]  index_i,
    input  logic [31:0] data_i,           // zero while idle
    output logic        not_finite_o,
    output logic [4:0]  not_finite_index_o,
    // to asip_plausible, two cycles later
    input  logic        read_record_i,
    input  logic        read_shown_i,     // the page that the host reads; otherwise the hidden one
    input  logic [4:0]  read_index_i,
    output logic [31:0] word_o,
    // from and to the host; safe values and the record are written while idle only
    input  logic        host_write_safe_i,
    input  logic        host_write_record_i,
    input  logic [4:0]  host_index_i,
    input  logic [31:0] host_data_i,
    output logic [31:0] host_read_o,
    output logic        parity_o,         // of the word read
    output logic        broken_o          // a register is
);

  localparam logic [1:0] PageSafe = 2'd2;
  localparam logic [1:0] PageRecord = 2'd3;
  localparam int unsigned WordWidth = Resilience != 0 ? 33 : 32;

  logic page_q, safe_q;
  logic [1:0] read_page, write_page;
  logic write_q, write_safe_q, write_record_q, not_finite_q, host_write;
  logic [4:0] index_q;
  logic page_d, safe_d;
  logic [31:0] data_d, data_q;
  logic [WordWidth-1:0] word, host_word, host_read_q;
  logic [31:0] record_word, record_word_q;

  assign not_finite_o       = not_finite_q;
  assign not_finite_index_o = index_q;
  assign write_page    = write_record_q ? PageRecord : write_safe_q ? PageSafe : {1'b0, !page_q};
  assign read_page     = (safe_q || fault_i) ? PageSafe : {1'b0, page_q};

  assign page_d = page_q ^ (commit_i && !fault_i);
  assign safe_d = fault_i || (safe_q && !commit_i);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      page_q       <= 1'b0;
      safe_q       <= 1'b1;
      write_q      <= 1'b0;
      not_finite_q <= 1'b0;
    end else begin
      write_q      <= write_i || host_write;
      not_finite_q <= write_i && (&data_i[30:23]);
      page_q       <= page_d;
      safe_q       <= safe_d;
    end
  end

  assign host_write = host_write_safe_i || host_write_record_i;
  assign data_d     = data_i | ({32{host_write}} & host_data_i);

  always_ff @(posedge clk_i) begin
    write_safe_q   <= host_write_safe_i;
    write_record_q <= host_write_record_i;
    index_q        <= host_write ? host_index_i : index_i;
    data_q         <= data_d;
    host_read_q    <= host_word;
    record_word_q  <= record_word;
  end

  // One copy for the host, one for the plausibility check.
  ram_block #(
      .Words(128),
      .Width(WordWidth)
  ) u_host (
      .clk_i,
      .write_i        (write_q),
      .write_address_i({write_page, index_q}),
      .write_data_i   (word),
      .read_i         (1'b1),
      .read_address_i ({read_page, host_index_i}),
      .read_data_o    (host_word)
  );

  ram_block #(
      .Words(128),
      .Width(32)
  ) u_record (
      .clk_i,
      .write_i        (write_q),
      .write_address_i({write_page, index_q}),
      .write_data_i   (data_q),
      .read_i         (1'b1),
      .read_address_i ({read_record_i ? PageRecord : {1'b0, page_q ^ !read_shown_i}, read_index_i}),
      .read_data_o    (record_word)
  );

  assign word_o      = record_word_q;

  assign host_read_o = host_read_q[31:0];

  generate
    if (Resilience != 0) begin : gen_parity
      localparam int unsigned Inverted = 10;
      logic parity_q;
      (* keep *) logic [Inverted-1:0] inverse_q;

      // The parity is that of the word before its register.
      always_ff @(posedge clk_i or negedge rst_ni) begin
        if (!rst_ni) inverse_q <= {1'b1, 1'b0, 8'hff};
        else begin
          inverse_q <= ~{page_d, safe_d, write_i || host_write, host_write_safe_i, host_write_record_i,
                       host_write ? host_index_i : index_i};
        end
      end
      always_ff @(posedge clk_i) parity_q <= ^data_d;

      assign word     = {parity_q, data_q};
      assign parity_o = host_read_q[WordWidth-1];
      assign broken_o = inverse_q[Inverted-1-:2] != ~{page_q, safe_q} ||
                      inverse_q[Inverted-3] != !write_q ||
                      (write_q && inverse_q[Inverted-4:0] != ~{write_safe_q, write_record_q, index_q});
    end else begin : gen_no_parity
      assign word     = data_q;
      assign parity_o = 1'b0;
      assign broken_o = 1'b0;
    end
  endgenerate

endmodule
