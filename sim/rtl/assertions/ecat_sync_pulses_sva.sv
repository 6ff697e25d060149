// SPDX-License-Identifier: Apache-2.0
// ecat_sync_pulses_sva: a pulse begins when the system time has come, not before, and lasts its length.
module ecat_sync_pulses_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic on_q,
    input logic [63:0] time_i,
    input logic [63:0] next_q,
    input logic [1:0] due_q,
    input logic [15:0] length_q,
    input logic [1:0] status_read,
    input logic [1:0] begins_o,
    input logic [1:0] sync_o
);

  logic        reached, reached_q, due_late_q;
  logic [63:0] ahead;
  assign ahead   = time_i - next_q;
  assign reached = on_q && !ahead[63];

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      reached_q  <= 1'b0;
      due_late_q <= 1'b0;
    end else begin
      reached_q  <= reached;
      due_late_q <= due_q[0];
    end
  end

  InTime : assert property (@(posedge clk_i) disable iff (!rst_ni)
      reached_q |-> due_q[0] || due_late_q)
  else $error("a time that has come makes no pulse");

  NotEarly : assert property (@(posedge clk_i) disable iff (!rst_ni)
      begins_o[0] |-> reached_q)
  else $error("SYNC0 begins before its time");

  for (genvar n = 0; n < 2; n++) begin : gen_pulse
    logic [15:0] first_q, age_q;  // the length at its beginning; clocks since its first
    logic        same_q;          // the length has not been changed since

    always_ff @(posedge clk_i or negedge rst_ni) begin
      if (!rst_ni) begin
        first_q <= '0;
        age_q   <= '0;
        same_q  <= 1'b0;
      end else if (begins_o[n]) begin
        first_q <= length_q;
        age_q   <= '0;
        same_q  <= 1'b1;
      end else begin
        if (age_q != '1) age_q <= age_q + 1'b1;
        if (length_q != first_q) same_q <= 1'b0;
      end
    end

    BeginsThePulse : assert property (@(posedge clk_i) disable iff (!rst_ni)
        begins_o[n] |=> sync_o[n])
    else $error("a pulse does not begin");

    NoPulseElse : assert property (@(posedge clk_i) disable iff (!rst_ni)
        sync_o[n] && !$past(sync_o[n]) |-> $past(begins_o[n]))
    else $error("a pulse begins by itself");

    BeginsApart : assert property (@(posedge clk_i) disable iff (!rst_ni)
        begins_o[n] |=> !begins_o[n])
    else $error("two pulses begin in a row");

    EndsInTime : assert property (@(posedge clk_i) disable iff (!rst_ni)
        sync_o[n] && same_q && first_q != '0 |-> age_q < first_q)
    else $error("a pulse is longer than PULSE_LENGTH");

    NotCutShort : assert property (@(posedge clk_i) disable iff (!rst_ni)
        sync_o[n] && same_q && length_q == first_q && (first_q == '0 ? !status_read[n] : age_q < first_q - 1'b1)
        |=> sync_o[n])
    else $error("a pulse is shorter than PULSE_LENGTH, or ends before its status is read");
  end

endmodule

bind ecat_sync_pulses ecat_sync_pulses_sva u_sva (.*);
