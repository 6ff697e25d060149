// SPDX-License-Identifier: Apache-2.0
// ecat_protection: whether a passing frame may write: protection of the registers, and of the whole controller.
// Contract: access_i and window_i are an access that the other guards allow to write (writes_i). refused_o answers at once, for
// frames alone: the commits of what was allowed, and the application, pass. A frame that has written 1 to an enable
// register may write from its next access on until its end. A protection holds from the frame after that which sets it.
module ecat_protection (
    input  logic clk_i,
    input  logic rst_ni,
    input  ecat_pkg::register_access_t register_i,
    input  logic frame_start_i,
    input  ecat_pkg::access_t access_i,
    input  ecat_pkg::window_t window_i,
    input  logic writes_i,
    output logic refused_o
);

  localparam int unsigned RegisterBit = 0, AllBit = 1;  // of the pairs below

  logic [1:0] protected_q, enabled_q, closed, enables;
  logic is_register;

  assign is_register         = window_i.address[15:12] == '0;
  assign enables[RegisterBit] = window_i.address == {4'd0, esc_regmap_pkg::REG_REGISTER_ENABLE};
  assign enables[AllBit]      = window_i.address == {4'd0, esc_regmap_pkg::REG_WRITE_ENABLE};
  assign closed               = protected_q & ~enabled_q;
  assign refused_o            = access_i.frame && enables == '0
                                && (closed[AllBit] || (closed[RegisterBit] && is_register));

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      protected_q <= '0;
      enabled_q   <= '0;
    end else begin
      if (frame_start_i) enabled_q <= '0;
      else if (access_i.frame && writes_i && access_i.data[0] && window_i.mask[0] && window_i.shift == '0)
        enabled_q <= enabled_q | enables;
      if (register_i.write && !register_i.application) begin
        case (register_i.address)
          esc_regmap_pkg::REG_REGISTER_PROTECTION:
          protected_q[RegisterBit] <= register_i.data[esc_regmap_pkg::REGISTER_PROTECTION_ON_LSB];
          esc_regmap_pkg::REG_WRITE_PROTECTION:
          protected_q[AllBit] <= register_i.data[esc_regmap_pkg::WRITE_PROTECTION_ON_LSB];
          default: ;
        endcase
      end
    end
  end

  logic unused;
  assign unused = &{access_i.valid, access_i.commit, access_i.application, access_i.read, access_i.write,
                    access_i.data, window_i.mask, window_i.high, register_i.read, register_i.data};

endmodule
