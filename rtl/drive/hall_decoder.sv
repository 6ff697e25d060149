// SPDX-License-Identifier: Apache-2.0
// hall_decoder: three Hall lines of a motor as the count of a drive axis, 6 * 2^Bits counts an electrical turn.
// Contract: {u, v, w} is 101, 100, 110, 010, 011, 001 as the angle rises; 000 and 111 are illegal. A state that lasted
// Filter + 1 clocks is taken, so position_o enters a sector 4 + Filter clocks after the line, and starts in the sector
// of the lines, not at 0: modulo 6 * 2^Bits it is the electrical angle. Within a sector it goes on from the edge by
// the time of the sector before, one count a clock at most, and stays within the sector. It is the sector's middle at
// the start, after a reversal, a fault, and Limit clocks without an edge. jump_o: a sector was skipped, position_o takes
// the shorter way, upwards for three. illegal_o: an illegal state; position_o stays in its sector.
module hall_decoder #(
    parameter int unsigned Bits   = 8,       // 2^Bits counts a sector, 2..16
    parameter int unsigned Filter = 15,      // clocks, 4..255
    parameter int unsigned Limit  = 1048575  // clocks of a sector at most, above 2^Bits, below 2^24
) (
    input  logic               clk_i,
    input  logic               rst_ni,
    input  logic               u_i,          // asynchronous
    input  logic               v_i,
    input  logic               w_i,
    // drive axis
    input  logic               clear_i,      // forgets jump_o, illegal_o and bad_count_o
    output logic signed [31:0] position_o,
    output logic               jump_o,
    output logic               illegal_o,
    output logic [7:0]         bad_count_o   // jumps and illegal states, 255 at most
);

  typedef enum logic [1:0] {
    StNone   = 2'd0,  // no sector
    StMiddle = 2'd1,  // a sector, no speed
    StMove   = 2'd2
  } state_e;

  localparam int unsigned TimeBits = $clog2(Limit + 1);
  localparam int unsigned SectorBits = 32 - Bits;
  localparam logic [TimeBits-1:0] LIMIT = TimeBits'(Limit);
  localparam logic [TimeBits:0] SIZE = (TimeBits + 1)'(1 << Bits);
  localparam logic [Bits-1:0] MIDDLE = {1'b1, {(Bits - 1) {1'b0}}};

  state_e state_q;
  logic [2:0] meta_q, line_q, seen_q, sector, place_q, forward;
  logic [7:0] lasted_q;
  logic [TimeBits-1:0] since_q, span_q;
  logic [TimeBits:0] rest_q, rest_next;
  logic [SectorBits-1:0] sectors_q, moved;
  logic [Bits-1:0] fraction_q;
  logic valid, legal, edge_found, single, down, late, count, begins_illegal, skips;
  logic timed_q, down_q, wrong_q;

  always_comb begin
    case (seen_q)
      3'b101:  sector = 3'd0;
      3'b100:  sector = 3'd1;
      3'b110:  sector = 3'd2;
      3'b010:  sector = 3'd3;
      3'b011:  sector = 3'd4;
      3'b001:  sector = 3'd5;
      default: sector = 3'd7;
    endcase
    case (forward)
      3'd4, 3'd5: moved = SectorBits'(forward) - SectorBits'(6);
      default: moved = SectorBits'(forward);
    endcase
  end

  assign valid          = lasted_q == 8'(Filter);
  assign legal          = sector != 3'd7;
  // Sectors from the last one, upwards.
  assign forward        = (sector >= place_q) ? sector - place_q : sector + 3'd6 - place_q;
  assign edge_found     = valid && legal && state_q != StNone && forward != 3'd0;
  assign single         = forward == 3'd1 || forward == 3'd5;
  assign down           = forward == 3'd5;
  assign skips          = edge_found && !single;
  assign begins_illegal = valid && !legal && !wrong_q;
  assign late           = since_q == LIMIT;
  // 2^Bits counts in span_q clocks.
  assign rest_next      = rest_q + SIZE;
  assign count          = rest_next >= {1'b0, span_q};
  assign position_o     = {sectors_q, fraction_q};

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q     <= StNone;
      meta_q      <= '0;
      line_q      <= '0;
      seen_q      <= '0;
      lasted_q    <= '0;
      place_q     <= '0;
      since_q     <= '0;
      span_q      <= '0;
      rest_q      <= '0;
      sectors_q   <= '0;
      fraction_q  <= MIDDLE;
      timed_q     <= 1'b0;
      down_q      <= 1'b0;
      wrong_q     <= 1'b0;
      jump_o      <= 1'b0;
      illegal_o   <= 1'b0;
      bad_count_o <= '0;
    end else begin
      meta_q <= {u_i, v_i, w_i};
      line_q <= meta_q;
      seen_q <= line_q;
      if (line_q != seen_q) lasted_q <= '0;
      else if (!valid) lasted_q <= lasted_q + 1'b1;

      if (valid) wrong_q <= !legal;
      jump_o    <= (jump_o && !clear_i) || skips;
      illegal_o <= (illegal_o && !clear_i) || (valid && !legal);
      if (clear_i) bad_count_o <= '0;
      else if ((skips || begins_illegal) && bad_count_o != '1) bad_count_o <= bad_count_o + 1'b1;

      if (!late) since_q <= since_q + 1'b1;
      if (valid && !legal) begin
        timed_q    <= 1'b0;
        fraction_q <= MIDDLE;
        if (state_q != StNone) state_q <= StMiddle;
      end else if (valid && state_q == StNone) begin
        state_q   <= StMiddle;
        place_q   <= sector;
        sectors_q <= SectorBits'(sector);
      end else if (edge_found) begin
        place_q   <= sector;
        sectors_q <= sectors_q + moved;
        since_q   <= '0;
        span_q    <= since_q + 1'b1;
        rest_q    <= '0;
        timed_q   <= single;
        down_q    <= down;
        if (single && timed_q && down == down_q && !late) begin
          state_q    <= StMove;
          fraction_q <= down ? '1 : '0;
        end else begin
          state_q    <= StMiddle;
          fraction_q <= MIDDLE;
        end
      end else if (late) begin
        timed_q    <= 1'b0;
        fraction_q <= MIDDLE;
        if (state_q != StNone) state_q <= StMiddle;
      end else if (state_q == StMove) begin
        rest_q <= count ? rest_next - {1'b0, span_q} : rest_next;
        if (count && down_q && fraction_q != '0) fraction_q <= fraction_q - 1'b1;
        if (count && !down_q && fraction_q != '1) fraction_q <= fraction_q + 1'b1;
      end
    end
  end

`ifndef SYNTHESIS
  generate
    if (Bits < 2 || Bits > 16 || Filter < 4 || Filter > 255) begin : gen_check_bits
      $error("hall_decoder: Bits=%0d, Filter=%0d, must be 2..16 and 4..255", Bits, Filter);
    end
    if (Limit <= (1 << Bits) || Limit > 16777215) begin : gen_check_limit
      $error("hall_decoder: Limit=%0d, must be above 2^Bits and below 2^24", Limit);
    end
  endgenerate
`endif

endmodule
