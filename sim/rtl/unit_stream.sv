// SPDX-License-Identifier: Apache-2.0
// unit_stream: feeds a pipelined unit one stimulus row per clock from a file and records its outputs.
// Files: +stimulus=<path> holds one hexadecimal row of StimulusWords 32-bit words per line, word 0
// (leftmost) is valid; +response=<path> receives one row of ResponseWords words per clock.
// Contract: row k is on stimulus_o after edge k and line e of the response is what response_i held
// just before edge e, so a unit of latency L answers row k in line k + L + 1. The run ends with the
// file. With +reset=<clocks> a reset falls in half a clock before that edge, from which rows and
// lines go on; a line `reset <row>` is what response_i held at an edge in reset. Simulation only.
module unit_stream #(
    parameter int unsigned StimulusWords = 2,
    parameter int unsigned ResponseWords = 2
) (
    output logic                        clk_o,
    output logic                        rst_no,
    output logic [32*StimulusWords-1:0] stimulus_o,
    input  logic [32*ResponseWords-1:0] response_i
);

  string stimulus_path, response_path;
  int stimulus_file, response_file, clocks;
  logic [32*StimulusWords-1:0] row;

  initial clk_o = 1'b0;
  always #1 clk_o = !clk_o;

  initial begin
    if (!$value$plusargs("stimulus=%s", stimulus_path)) $fatal(1, "no +stimulus=<path>");
    if (!$value$plusargs("response=%s", response_path)) $fatal(1, "no +response=<path>");
    stimulus_file = $fopen(stimulus_path, "r");
    response_file = $fopen(response_path, "w");
    if (stimulus_file == 0 || response_file == 0) $fatal(1, "cannot open a vector file");
    rst_no = 1'b0;
    repeat (2) @(negedge clk_o);
    rst_no = 1'b1;
    if ($value$plusargs("reset=%d", clocks)) begin
      repeat (clocks) @(negedge clk_o);
      rst_no = 1'b0;
      @(posedge clk_o);
      $fdisplay(response_file, "reset %h", response_i);
      @(negedge clk_o);
      rst_no = 1'b1;
    end
  end

  always_ff @(posedge clk_o or negedge rst_no) begin
    if (!rst_no) begin
      stimulus_o <= '0;
    end else begin
      $fdisplay(response_file, "%h", response_i);
      if ($fscanf(stimulus_file, "%h", row) == 1) stimulus_o <= row;
      else begin
        $fclose(response_file);
        $finish;
      end
    end
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
