// SPDX-License-Identifier: Apache-2.0
// fpbench: so many lanes of one arithmetic unit that the cost of a simulator call is shared.
// Contract: all lanes take an operation together when valid_i && ready_o; valid_o, result_o, flags_o
// come latency_o edges later. Operands are registered before the units, so that the falling clock
// edge costs the simulator nothing. Iterative: the unit is not ready while it works. Simulation only.
module fpbench #(
    parameter int unsigned Lanes = 4,
    parameter bit Iterative = 1'b0
) (
    input  logic        clk_i,
    input  logic        rst_ni,
    input  logic        valid_i,
    input  logic [3:0]  control_i,
    input  logic [31:0] a_i      [Lanes],
    input  logic [31:0] b_i      [Lanes],
    input  logic [31:0] c_i      [Lanes],
    output logic [Lanes-1:0] ready_o,
    output logic [Lanes-1:0] valid_o,
    output logic [31:0] result_o [Lanes],
    output logic [7:0]  flags_o  [Lanes],
    output logic [31:0] latency_o,
    output logic [31:0] lanes_o
);

  logic valid;
  logic [3:0] control;
  logic [31:0] a[Lanes], b[Lanes], c[Lanes];
  logic [31:0] latency[Lanes];

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) valid <= 1'b0;
    else valid <= valid_i;
  end
  always_ff @(posedge clk_i) begin
    control <= control_i;
    a       <= a_i;
    b       <= b_i;
    c       <= c_i;
  end

  assign lanes_o   = Lanes;
  assign latency_o = latency[0] + 32'd1;   // the rank before the lanes

  for (genvar i = 0; i < int'(Lanes); i++) begin : gen_lane
    logic ready;
    logic [4:0] flags;
    assign flags_o[i] = {3'd0, flags};
    assign ready_o[i] = ready && !(Iterative && valid);   // an operation waits in the rank
    fp_lane lane (
        .clk_i,
        .rst_ni,
        .valid_i(valid),
        .control_i(control),
        .a_i(a[i]),
        .b_i(b[i]),
        .c_i(c[i]),
        .ready_o(ready),
        .valid_o(valid_o[i]),
        .result_o(result_o[i]),
        .flags_o(flags),
        .latency_o(latency[i])
    );
  end

endmodule
