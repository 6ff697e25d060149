// SPDX-License-Identifier: Apache-2.0
// sincos_stream: runs fp_sincos or fp_sincos_overlapped over a file of operands.
// Files: +stimulus=<path> holds one line per operand, {cos, operand} as 33 bits in hexadecimal and the
// clocks that the unit is left idle before it takes it; +response=<path> receives {latency, interval,
// flags, result} per operand: register ranks from acceptance to result, clocks until the unit is ready
// again, five flag bits, 32 result bits.
// Contract: operands change while the unit works and requests while it is busy must be ignored; a
// result without an operand ends the run with an error. Simulation only.
module sincos_stream #(
    parameter bit Overlapped = 1'b0
);

  localparam int Patience = 100;  // clocks for a result

  string stimulus_path, response_path;
  int stimulus_file, response_file, idle, now, ready_after;
  int accepted[$], intervals[$];
  logic more, measuring;
  logic clk, rst_n, valid_in, ready, valid_out;
  logic [32:0] next_operand, operand;
  logic [31:0] result;
  fp_pkg::flags_t flags;

  if (Overlapped) begin : gen_overlapped
    fp_sincos_overlapped dut (
        .clk_i   (clk),
        .rst_ni  (rst_n),
        .valid_i (valid_in),
        .cos_i   (operand[32]),
        .a_i     (operand[31:0]),
        .ready_o (ready),
        .valid_o (valid_out),
        .result_o(result),
        .flags_o (flags)
    );
  end else begin : gen_iterative
    fp_sincos dut (
        .clk_i   (clk),
        .rst_ni  (rst_n),
        .valid_i (valid_in),
        .cos_i   (operand[32]),
        .a_i     (operand[31:0]),
        .ready_o (ready),
        .valid_o (valid_out),
        .result_o(result),
        .flags_o (flags)
    );
  end

  initial clk = 1'b0;
  always #1 clk = !clk;

  task automatic fail(input string text);
    $display("sincos_stream: %s", text);
    $fatal(1);
  endtask

  task automatic take();
    more = $fscanf(stimulus_file, "%h %d", next_operand, idle) == 2;
  endtask

  initial begin
    if (!$value$plusargs("stimulus=%s", stimulus_path)) fail("no +stimulus=<path>");
    if (!$value$plusargs("response=%s", response_path)) fail("no +response=<path>");
    stimulus_file = $fopen(stimulus_path, "r");
    response_file = $fopen(response_path, "w");
    if (stimulus_file == 0 || response_file == 0) fail("cannot open a vector file");
    rst_n     = 1'b0;
    valid_in  = 1'b0;
    measuring = 1'b0;
    now       = 0;
    repeat (2) @(negedge clk);
    rst_n = 1'b1;
    take();
    while (more || accepted.size() > 0) begin
      @(negedge clk);
      now++;
      if (measuring && ready) begin
        intervals.push_back(now - ready_after);
        measuring = 1'b0;
      end
      if (valid_out) begin
        if (accepted.size() == 0) fail("valid_o without operand");
        $fdisplay(response_file, "%h %h %h %h", 8'(now - accepted.pop_front()), 8'(intervals.pop_front()), {
                  3'b000, flags}, result);
      end
      if (accepted.size() > 0 && now - accepted[0] > Patience) fail("no result");
      operand = {$urandom_range(1) == 1, $urandom()};
      if (!ready) valid_in = $urandom_range(1) == 1;  // to be ignored
      else if (more && idle == 0) begin
        valid_in    = 1'b1;
        operand     = next_operand;
        ready_after = now;
        measuring   = 1'b1;
        accepted.push_back(now);
        take();
      end else begin
        valid_in = 1'b0;
        idle--;
      end
    end
    repeat (Patience) begin
      @(negedge clk);
      valid_in = 1'b0;
      if (valid_out) fail("valid_o without operand");
    end
    $fclose(response_file);
    $finish;
  end

`ifdef WAVES
  string waves;
  initial
    if ($value$plusargs("waves=%s", waves)) begin
      $dumpfile(waves);
      $dumpvars;
    end
`endif

endmodule
