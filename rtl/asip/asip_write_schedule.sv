// SPDX-License-Identifier: Apache-2.0
// asip_write_schedule: future writes of one bank, one place per cycle.
// Contract: place r holds the write that happens in r cycles; every cycle all places move down by one.
// An operation of latency L that issues now is inserted at place L + 2 of the next cycle, so one that
// issues in the next cycle collides if taken_o[L + 3] is set. Place 4 is announced to the hazard logic,
// places 2, 1 and 0 decide the bypass, place 0 is write-back.
module asip_write_schedule #(
    parameter int unsigned Places = 10  // latency of the slowest unit + 4
) (
    input  logic                      clk_i,
    input  logic                      rst_ni,
    // from issue: latency of the operation and its destination
    input  logic                      insert_i,
    input  logic [$clog2(Places)-1:0] latency_i,
    input  asip_pkg::tag_t            tag_i,
    // a unit with a longer latency joins at the last place
    input  logic                      join_i,
    input  asip_pkg::tag_t            join_tag_i,
    output logic [Places-1:0]         taken_o,  // in the next cycle, apart from an insertion
    output logic [4:0]                valid_o,  // places 4 to 0
    output asip_pkg::tag_t            tag4_o,
    output asip_pkg::tag_t            tag2_o,
    output asip_pkg::tag_t            tag1_o,
    output asip_pkg::tag_t            tag0_o,
    output logic                      busy_o    // a write in one cycle or later
);

  localparam int unsigned PlaceWidth = $clog2(Places);

  logic [Places-1:0] valid_d, valid_q;
  logic [Places-1:0][asip_pkg::TAG_WIDTH-1:0] tag_d, tag_q;
  logic [PlaceWidth-1:0] place;

  assign place   = latency_i + PlaceWidth'(2);
  assign taken_o = {join_i, valid_q[Places-1:1]};

  always_comb begin
    valid_d = {join_i, valid_q[Places-1:1]};
    tag_d   = {join_tag_i, tag_q[Places-1:1]};
    if (insert_i) begin
      valid_d[place] = 1'b1;
      tag_d[place]   = tag_i;
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) valid_q <= '0;
    else valid_q <= valid_d;
  end

  always_ff @(posedge clk_i) tag_q <= tag_d;

  assign valid_o = valid_q[4:0];
  assign tag4_o  = tag_q[4];
  assign tag2_o  = tag_q[2];
  assign tag1_o  = tag_q[1];
  assign tag0_o  = tag_q[0];
  assign busy_o  = |valid_q[Places-1:1];

endmodule
