// SPDX-License-Identifier: Apache-2.0
// sincos_stream: runs fp_sincos over a file of operands, at full rate or with gaps.
// Files: +stimulus=<path> holds one hexadecimal word per line, {cos, operand} as 33 bits;
// +response=<path> receives {latency, flags, result} per operand: register ranks from acceptance to
// result, five flag bits, 32 result bits. +gaps leaves pseudo-random idle clocks between operands.
// Contract: operands change while the unit works; valid_o outside a computation ends the run with
// an error. Simulation only.
module sincos_stream;

  string       stimulus_path, response_path;
  int          stimulus_file, response_file, latency;
  logic        gaps, more;
  logic        clk, rst_n, valid_in, ready, valid_out;
  logic [32:0] operand;
  logic [31:0] result;
  fp_pkg::flags_t flags;

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

  initial clk = 1'b0;
  always #1 clk = !clk;

  task automatic fail(input string text);
    $display("sincos_stream: %s", text);
    $fatal(1);
  endtask

  initial begin
    if (!$value$plusargs("stimulus=%s", stimulus_path)) fail("no +stimulus=<path>");
    if (!$value$plusargs("response=%s", response_path)) fail("no +response=<path>");
    gaps          = $test$plusargs("gaps") != 0;
    stimulus_file = $fopen(stimulus_path, "r");
    response_file = $fopen(response_path, "w");
    if (stimulus_file == 0 || response_file == 0) fail("cannot open a vector file");
    rst_n    = 1'b0;
    valid_in = 1'b0;
    repeat (2) @(negedge clk);
    rst_n = 1'b1;
    more  = $fscanf(stimulus_file, "%h", operand) == 1;
    while (more) begin
      if (!ready) fail("not ready when idle");
      valid_in = 1'b1;
      @(negedge clk);
      latency  = 1;
      operand  = ~operand;
      valid_in = gaps;            // a request while busy must be ignored
      while (!valid_out && latency < 100) begin
        if (ready) fail("ready while busy");
        @(negedge clk);
        latency++;
      end
      $fdisplay(response_file, "%h %h %h", 8'(latency), {3'b000, flags}, result);
      more     = $fscanf(stimulus_file, "%h", operand) == 1;
      valid_in = 1'b0;
      if (gaps) begin
        repeat ($urandom_range(3)) begin
          @(negedge clk);
          if (valid_out) fail("valid_o without operand");
        end
      end
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
