// SPDX-License-Identifier: Apache-2.0
// ecat_reset: reset of controller and application that the master asks for: R, E, S in ESC_RESET, a byte a frame.
// Contract: a frame counts by the last byte that it writes, from done_i on; any other byte restarts the sequence. Hold clocks after
// the third frame, so that it has left and come back, reset_no is low for Length clocks, and rst_n is that or rst_ni,
// straight from a register. live_* as in ecat_control: how many bytes were right.
module ecat_reset #(
    parameter int unsigned Hold   = 16384,
    parameter int unsigned Length = 16
) (
    input  logic clk_i,
    input  logic rst_ni,
    input  ecat_pkg::register_access_t register_i,
    input  logic        done_i,          // a frame's writes are in force
    input  logic [11:0] live_address_i,
    output logic        live_hit_o,
    output logic [7:0]  live_data_o,
    output logic        reset_no
);

  localparam int unsigned Width = $clog2(Hold + Length);

  typedef enum logic [1:0] {
    StNone  = 2'd0,
    StOne   = 2'd1,  // R
    StTwo   = 2'd2,  // R, E
    StReset = 2'd3
  } state_e;

  state_e state_q;
  logic written_q, active_nq;
  logic [7:0] data_q, wanted;
  logic [Width-1:0] left_q;

  always_comb begin
    case (state_q)
      StNone: wanted = 8'h52;
      StOne: wanted = 8'h45;
      default: wanted = 8'h53;
    endcase
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q   <= StNone;
      written_q <= 1'b0;
      data_q    <= '0;
      left_q    <= '0;
      active_nq <= 1'b0;
    end else begin
      active_nq <= !(state_q == StReset && left_q < Width'(Length));
      if (register_i.write && !register_i.application && register_i.address == esc_regmap_pkg::REG_ESC_RESET) begin
        written_q <= 1'b1;
        data_q    <= register_i.data;
      end else if (done_i) begin
        written_q <= 1'b0;
      end
      left_q <= left_q - 1'b1;
      case (state_q)
        StNone: if (done_i && written_q && data_q == wanted) state_q <= StOne;
        StOne: if (done_i && written_q) state_q <= data_q == wanted ? StTwo : StNone;
        StTwo: begin
          left_q <= Width'(Hold + Length - 1);
          if (done_i && written_q) state_q <= data_q == wanted ? StReset : StNone;
        end
        default: if (left_q == '0) state_q <= StNone;
      endcase
    end
  end

  assign reset_no    = active_nq;
  assign live_hit_o  = live_address_i == esc_regmap_pkg::REG_ESC_RESET;
  assign live_data_o = 8'(state_q);

  logic unused;
  assign unused = &{register_i.read};

endmodule
