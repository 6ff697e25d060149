// SPDX-License-Identifier: Apache-2.0
// mii_receive: nibbles of an MII receiver, in the clock of the controller, one a tick.
// Contract: clk_i runs at 100 MHz, MII at 25 MHz; its clock is sampled, data are taken at its rising edge. A
// frame's nibbles leave without a gap, from the first that came: two lie in store before the first leaves, so
// clocks up to 200 ppm apart neither empty nor fill it within a frame of 1536 bytes. start_o is high for a
// clock, always as long after the receiver's first nibble: a time stamp does not see the ticks.
module mii_receive (
    input  logic clk_i,
    input  logic rst_ni,
    input  logic tick_i,       // one clock in four, in the phase of the transmitters
    // MII
    input  logic mii_clk_i,
    input  logic mii_valid_i,
    input  logic mii_error_i,
    input  logic [3:0] mii_data_i,
    // to the controller
    output logic start_o,
    output ecat_pkg::nibble_t nibble_o  // new after each tick
);

  localparam int unsigned Depth = 8;
  localparam logic [3:0] Store = 4'd2;

  logic [2:0] clock_q;
  logic [5:0] now_q, then_q;
  logic active_q, reading_q, take, pop;
  logic [4:0] store_q[0:Depth-1];
  logic [3:0] head_q, tail_q, level;
  ecat_pkg::nibble_t nibble_q;

  assign take  = clock_q[1] && !clock_q[2];
  assign level = head_q - tail_q;
  assign pop   = tick_i && level != '0 && (reading_q || level >= Store);

  always_ff @(posedge clk_i) begin
    now_q  <= {mii_valid_i, mii_error_i, mii_data_i};
    then_q <= now_q;
    if (take) store_q[head_q[2:0]] <= then_q[4:0];
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      clock_q   <= '0;
      active_q  <= 1'b0;
      reading_q <= 1'b0;
      head_q    <= '0;
      tail_q    <= '0;
      start_o   <= 1'b0;
      nibble_q  <= '0;
    end else begin
      clock_q <= {clock_q[1:0], mii_clk_i};
      start_o <= take && then_q[5] && !active_q;
      if (take) begin
        active_q <= then_q[5];
        if (then_q[5]) head_q <= head_q + 1'b1;
      end
      if (tick_i) begin
        reading_q <= pop;
        if (pop) begin
          tail_q   <= tail_q + 1'b1;
          nibble_q <= {1'b1, store_q[tail_q[2:0]]};
        end else begin
          nibble_q <= '0;
        end
      end
    end
  end

  assign nibble_o = nibble_q;

endmodule
