// SPDX-License-Identifier: Apache-2.0
// ecat_fmmus_sva: an FMMU that is not active maps nothing, and a window says where its bits lie.
module ecat_fmmus_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic [2:0] slot_i,
    input logic [ecat_pkg::FMMUS-1:0] active_q,
    input ecat_pkg::window_t window_o,
    input logic read_o,
    input logic write_o
);

  logic [15:0] place;  // of the window's bits in two bytes
  assign place = {8'd0, window_o.mask} << window_o.shift;

  OnlyActiveOnes : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $past(rst_ni, 3) && (window_o.mask != '0 || read_o || write_o) |-> $past(active_q[slot_i], 3))
  else $error("an FMMU maps that is not active");

  AccessOfBits : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $past(rst_ni, 3) && (read_o || write_o) |-> window_o.mask != '0)
  else $error("an access to no bit");

  HighIsTheByteBehind : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $past(rst_ni, 3) && window_o.mask != '0 |-> window_o.high == (place[7:0] == '0))
  else $error("a window is not where its bits are");

endmodule

bind ecat_fmmus ecat_fmmus_sva u_sva (.*);
