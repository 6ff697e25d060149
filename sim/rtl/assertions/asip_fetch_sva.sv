// SPDX-License-Identifier: Apache-2.0
// asip_fetch_sva: six cycles from a redirect to its bundle in D; a bundle that waits in D is held.
module asip_fetch_sva #(
    parameter int unsigned DecodedWidth = 1
) (
    input logic clk_i,
    input logic rst_ni,
    input logic redirect_i,
    input logic [15:0] redirect_pc_i,
    input logic advance_i,
    input logic valid_d_o,
    input logic [15:0] pc_d_o,
    input logic [DecodedWidth-1:0] decoded_d_o
);

  // Cycles since the last redirect, up to 6, and where it went.
  logic [2:0]  since_q;
  logic [15:0] target_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) since_q <= 3'd0;
    else if (redirect_i) since_q <= 3'd1;
    else if (since_q != 3'd0 && since_q != 3'd7) since_q <= since_q + 3'd1;
  end

  always_ff @(posedge clk_i) if (redirect_i) target_q <= redirect_pc_i;

  SixCycles : assert property (@(posedge clk_i) disable iff (!rst_ni)
      since_q == 3'd6 |-> valid_d_o && pc_d_o == target_q)
  else $error("the target of a redirect is not in D after six cycles");

  NothingBefore : assert property (@(posedge clk_i) disable iff (!rst_ni)
      since_q inside {[3'd1 : 3'd5]} |-> !valid_d_o)
  else $error("a bundle from before a redirect is in D");

  HeldInD : assert property (@(posedge clk_i) disable iff (!rst_ni)
      valid_d_o && !advance_i && !redirect_i |=> valid_d_o && $stable(pc_d_o) && $stable(decoded_d_o))
  else $error("a bundle left D without issuing");

endmodule

bind asip_fetch asip_fetch_sva #(
    .DecodedWidth(DecodedWidth)
) u_sva (.*);
