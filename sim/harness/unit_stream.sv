// SPDX-License-Identifier: Apache-2.0
// unit_stream: feeds a pipelined unit one stimulus row per clock from a file and records its outputs.
// Files: +stimulus=<path> holds one hexadecimal row of StimulusWords 32-bit words per line, word 0
// (leftmost) is valid; +response=<path> receives one row of ResponseWords words per clock.
// Contract: row k is on stimulus_o after edge k and line e of the response is what response_i held
// just before edge e, so a unit of latency L answers row k in line k + L + 1. Simulation only.
module unit_stream #(
    parameter int unsigned StimulusWords = 2,
    parameter int unsigned ResponseWords = 2
) (
    input  logic                        clk_i,
    input  logic                        rst_ni,
    output logic [32*StimulusWords-1:0] stimulus_o,
    input  logic [32*ResponseWords-1:0] response_i,
    output logic                        done_o
);

  string stimulus_path, response_path;
  int    stimulus_file, response_file;
  logic [32*StimulusWords-1:0] row;

  initial begin
    if (!$value$plusargs("stimulus=%s", stimulus_path)) $fatal(1, "no +stimulus=<path>");
    if (!$value$plusargs("response=%s", response_path)) $fatal(1, "no +response=<path>");
    stimulus_file = $fopen(stimulus_path, "r");
    response_file = $fopen(response_path, "w");
    if (stimulus_file == 0 || response_file == 0) $fatal(1, "cannot open a vector file");
  end

  final $fclose(response_file);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      stimulus_o <= '0;
      done_o     <= 1'b0;
    end else if (!done_o) begin
      $fdisplay(response_file, "%h", response_i);
      if ($fscanf(stimulus_file, "%h", row) == 1) stimulus_o <= row;
      else done_o <= 1'b1;
    end
  end

endmodule
