// SPDX-License-Identifier: Apache-2.0
// ecat_write_log: keeps what a frame wants to change until its check sequence was good, then gives it out in order.
// Contract: entries come with push_i after clear_i; commit_i begins to give them out, drop_o shows that there were
// more than there is room for and nothing is given out. busy_o lasts until Drain clocks after the last entry, so that it has
// taken effect; no push_i and no commit_i while busy_o. An entry is held until ready_i.
module ecat_write_log #(
    parameter int unsigned Depth = 2048
) (
    input  logic clk_i,
    input  logic rst_ni,
    input  logic clear_i,
    input  logic push_i,
    input  logic [ecat_pkg::LOG_WIDTH-1:0] entry_i,
    input  logic commit_i,
    output logic drop_o,
    output logic busy_o,
    output logic done_o,   // busy_o ends
    output logic valid_o,
    output logic [ecat_pkg::LOG_WIDTH-1:0] entry_o,
    input  logic ready_i
);

  localparam int unsigned Width = $clog2(Depth);
  localparam logic [3:0] Drain = 4'd14;

  logic [Width:0] count_q, left_q;
  logic [Width-1:0] place_q, place;
  logic [3:0] drain_q;
  logic busy_q, valid_q, over_q, take;

  assign take  = valid_q && ready_i;
  assign place = take ? place_q + 1'b1 : place_q;

  // What is read while something is pushed is not used.
  ram_block #(
      .Words(Depth),
      .Width(ecat_pkg::LOG_WIDTH)
  ) u_store (
      .clk_i,
      .write_i        (push_i && !count_q[Width]),
      .write_address_i(count_q[Width-1:0]),
      .write_data_i   (entry_i),
      .read_i         (1'b1),
      .read_address_i (place),
      .read_data_o    (entry_o)
  );

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      count_q <= '0;
      left_q  <= '0;
      place_q <= '0;
      drain_q <= '0;
      busy_q  <= 1'b0;
      valid_q <= 1'b0;
      over_q  <= 1'b0;
    end else begin
      if (clear_i) begin
        count_q <= '0;
        over_q  <= 1'b0;
      end else if (push_i) begin
        if (count_q[Width]) over_q <= 1'b1;
        else count_q <= count_q + 1'b1;
      end
      place_q <= place;
      if (commit_i && count_q != '0 && !over_q) begin
        busy_q  <= 1'b1;
        left_q  <= count_q;
        place_q <= '0;
        drain_q <= Drain;
      end else if (busy_q) begin
        valid_q <= left_q != '0 && !(take && left_q == {{Width{1'b0}}, 1'b1});
        if (take) left_q <= left_q - 1'b1;
        if (left_q == '0) drain_q <= drain_q - 1'b1;
        if (drain_q == '0) busy_q <= 1'b0;
      end
    end
  end

  assign drop_o  = over_q;
  assign busy_o  = busy_q;
  assign done_o  = busy_q && drain_q == '0;
  assign valid_o = valid_q;

endmodule
