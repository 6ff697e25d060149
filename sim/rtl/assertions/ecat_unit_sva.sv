// SPDX-License-Identifier: Apache-2.0
// ecat_unit_sva: what comes leaves Delay ticks later and nothing else does; a frame counts as good only if it is.
module ecat_unit_sva #(
    parameter int unsigned Delay = 8
) (
    input logic clk_i,
    input logic rst_ni,
    input logic tick_i,
    input ecat_pkg::nibble_t nibble_i,
    input ecat_pkg::nibble_t nibble_o,
    input logic destroy_i,
    input logic looped_i,
    input logic spoilt_i,
    input logic reads,          // result_i goes out
    input logic [7:0] result_i,
    input logic frame_start_o,
    input logic byte_valid_o,
    input logic frame_end_o,
    input logic frame_bad_o,
    input logic frame_good_o
);

  logic [Delay:0] line_q;  // nibbles that came; the last one has just left
  logic           cut_q, destroyed_q, silent_q, begun_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      line_q      <= '0;
      cut_q       <= 1'b0;
      destroyed_q <= 1'b0;
      silent_q    <= 1'b0;
      begun_q     <= 1'b0;
    end else begin
      begun_q     <= frame_start_o || (begun_q && !frame_end_o);
      cut_q       <= destroy_i || looped_i || (cut_q && line_q != '0);
      destroyed_q <= destroy_i || (destroyed_q && line_q[Delay-1:0] != '0);
      if (tick_i) begin
        line_q   <= {line_q[Delay-1:0], nibble_i.valid};
        silent_q <= destroy_i || (destroyed_q && line_q[Delay-1:0] != '0);
      end
    end
  end

  NothingElseLeaves : assert property (@(posedge clk_i) disable iff (!rst_ni)
      nibble_o.valid |-> line_q[Delay])
  else $error("a nibble leaves that did not come Delay ticks before");

  AllThatCameLeave : assert property (@(posedge clk_i) disable iff (!rst_ni)
      line_q[Delay] && !cut_q |-> nibble_o.valid)
  else $error("a nibble does not leave Delay ticks behind its coming");

  DestroyedIsSilent : assert property (@(posedge clk_i) disable iff (!rst_ni)
      silent_q |-> !nibble_o.valid)
  else $error("a destroyed frame goes on");

  AnswerStands : assert property (@(posedge clk_i) disable iff (!rst_ni)
      tick_i && reads |-> $stable(result_i))
  else $error("an answer comes in the clock in which it leaves");

  ByteOfAFrame : assert property (@(posedge clk_i) disable iff (!rst_ni)
      byte_valid_o |-> begun_q)
  else $error("a byte before its frame's beginning or behind its end");

  EndOnce : assert property (@(posedge clk_i) disable iff (!rst_ni)
      frame_end_o |=> !frame_end_o)
  else $error("a frame ends twice");

  GoodAtTheEnd : assert property (@(posedge clk_i) disable iff (!rst_ni)
      frame_good_o |-> frame_end_o && !frame_bad_o && !spoilt_i)
  else $error("a frame counts as good that is not over, is bad or is spoilt");

endmodule

bind ecat_unit ecat_unit_sva #(
    .Delay(Delay)
) u_sva (
    .reads(low_q[Delay-1] && !check && !destroyed_q),
    .*
);
