// SPDX-License-Identifier: Apache-2.0
// asip_outputs: output words in three pages: two that runs fill in turn, one of safe values.
// Contract: a run writes the hidden page; commit_i shows it. From reset, and from a fault on, until the
// next commit the host reads the safe page. Reads take two cycles. A word is registered before it is
// stored and judged: not_finite_o comes, with its index, a cycle after write-back.
module asip_outputs (
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
    // from and to the host; safe values are written while idle only
    input  logic        host_write_safe_i,
    input  logic [4:0]  host_index_i,
    input  logic [31:0] host_data_i,
    output logic [31:0] host_read_o
);

  localparam logic [1:0] PageSafe = 2'd2;

  logic        page_q, safe_q;
  logic [1:0]  read_page, write_page;
  logic        write_q, write_safe_q, not_finite_q;
  logic [4:0]  index_q;
  logic [31:0] data_q, read_q, host_read_q;
  logic [31:0] memory[0:127];

  assign not_finite_o       = not_finite_q;
  assign not_finite_index_o = index_q;
  assign write_page    = write_safe_q ? PageSafe : {1'b0, !page_q};
  assign read_page     = (safe_q || fault_i) ? PageSafe : {1'b0, page_q};

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      page_q       <= 1'b0;
      safe_q       <= 1'b1;
      write_q      <= 1'b0;
      not_finite_q <= 1'b0;
    end else begin
      write_q      <= write_i || host_write_safe_i;
      not_finite_q <= write_i && (&data_i[30:23]);
      if (fault_i) begin
        safe_q <= 1'b1;
      end else if (commit_i) begin
        page_q <= !page_q;
        safe_q <= 1'b0;
      end
    end
  end

  always_ff @(posedge clk_i) begin
    write_safe_q <= host_write_safe_i;
    index_q      <= host_write_safe_i ? host_index_i : index_i;
    data_q       <= data_i | ({32{host_write_safe_i}} & host_data_i);
    if (write_q) memory[{write_page, index_q}] <= data_q;
    read_q      <= memory[{read_page, host_index_i}];
    host_read_q <= read_q;
  end

  assign host_read_o = host_read_q;

endmodule
