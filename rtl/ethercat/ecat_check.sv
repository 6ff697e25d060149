// SPDX-License-Identifier: Apache-2.0
// ecat_check: whether a stream's frames are good, by alignment, RX_ER and check sequence.
// Contract: after the tick that took a frame's last nibble, bad_o and marked_o say of it what holds until
// the next frame's first nibble; marked_o: an earlier slave saw it bad and inverted the sequence. Bytes begin after
// the start delimiter; end_o is high for the tick after the last nibble, of frames that had a delimiter.
module ecat_check (
    input  logic clk_i,
    input  logic rst_ni,
    input  logic tick_i,
    input  ecat_pkg::nibble_t nibble_i,
    output logic body_o,    // the present nibble belongs to a byte
    output logic odd_o,     // and is the upper half of it
    output logic end_o,
    output logic bad_o,
    output logic marked_o,
    output logic error_o    // RX_ER in the frame
);

  localparam logic [3:0] Delimiter = 4'hD;

  logic [31:0] state_q;
  logic body_q, odd_q, error_q;

  assign body_o   = body_q && nibble_i.valid;
  assign odd_o    = odd_q;
  assign end_o    = body_q && !nibble_i.valid;
  assign marked_o = state_q == ecat_pkg::RESIDUE_MARKED && !odd_q && !error_q;
  assign bad_o    = state_q != ecat_pkg::RESIDUE_GOOD || odd_q || error_q;
  assign error_o  = error_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      body_q  <= 1'b0;
      odd_q   <= 1'b0;
      error_q <= 1'b0;
      state_q <= '1;
    end else if (tick_i) begin
      if (!nibble_i.valid) begin
        body_q <= 1'b0;
      end else if (!body_q) begin
        body_q  <= nibble_i.data == Delimiter;
        odd_q   <= 1'b0;
        error_q <= nibble_i.error;
        state_q <= '1;
      end else begin
        odd_q   <= !odd_q;
        error_q <= error_q || nibble_i.error;
        state_q <= ecat_pkg::check_sequence(state_q, nibble_i.data);
      end
    end
  end

endmodule
