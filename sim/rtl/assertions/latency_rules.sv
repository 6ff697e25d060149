// SPDX-License-Identifier: Apache-2.0
// latency_rules: a unit that never stalls answers each operation exactly Latency clocks later, and
// answers nothing else.
module latency_rules #(
    parameter int unsigned Latency = 1
) (
    input logic clk_i,
    input logic rst_ni,
    input logic start,
    input logic done
);

  logic [Latency-1:0] expected_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) expected_q <= '0;
    else expected_q <= Latency'({expected_q, start});
  end

  InTime : assert property (@(posedge clk_i) disable iff (!rst_ni) done == expected_q[Latency-1])
  else $error("a result without an operation, or not after its latency");

endmodule
