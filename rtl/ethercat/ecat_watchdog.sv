// SPDX-License-Identifier: Apache-2.0
// ecat_watchdog: watchdogs of the process data and of the application, with one divider.
// Contract: a watchdog begins with its first trigger and runs out WATCHDOG_* units after the last one, once; the next
// trigger lets it live again. A unit is WATCHDOG_DIVIDER + 2 times 40 ns. Time 0 switches one off. expired_o: the process
// data's runs out. live_* as in ecat_control.
module ecat_watchdog (
    input  logic clk_i,
    input  logic rst_ni,
    input  ecat_pkg::register_access_t register_i,
    input  logic [11:0] live_address_i,
    output logic        live_hit_o,
    output logic [7:0]  live_data_o,
    input  logic        data_trigger_i,
    input  logic        application_trigger_i,
    output logic        expired_o,
    output logic        application_alive_o
);

  logic [15:0] divider_q;
  logic [18:0] clocks_q;
  logic [18:0] unit_clocks;
  logic unit;
  logic [1:0] trigger, expired, alive;
  logic [15:0] counts;

  assign unit_clocks = {{1'b0, divider_q} + 17'd2, 2'b00};
  assign trigger     = {application_trigger_i, data_trigger_i};

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      divider_q <= esc_regmap_pkg::RESET_WATCHDOG_DIVIDER;
      clocks_q  <= '0;
      unit      <= 1'b0;
    end else begin
      unit     <= clocks_q == 19'd1;
      clocks_q <= clocks_q <= 19'd1 ? unit_clocks : clocks_q - 1'b1;
      if (register_i.write && register_i.address == esc_regmap_pkg::REG_WATCHDOG_DIVIDER) begin
        divider_q[7:0] <= register_i.data;
      end
      if (register_i.write && register_i.address == esc_regmap_pkg::REG_WATCHDOG_DIVIDER + 12'd1) begin
        divider_q[15:8] <= register_i.data;
      end
    end
  end

  genvar n;
  generate
    for (n = 0; n < 2; n++) begin : gen_watchdog
      localparam logic [11:0] Time = n == 0 ? esc_regmap_pkg::REG_WATCHDOG_DATA : esc_regmap_pkg::REG_WATCHDOG_PDI;
      localparam logic [15:0] First = n == 0 ? esc_regmap_pkg::RESET_WATCHDOG_DATA : esc_regmap_pkg::RESET_WATCHDOG_PDI;
      localparam logic [11:0] Count =
        n == 0 ? esc_regmap_pkg::REG_WATCHDOG_DATA_COUNT : esc_regmap_pkg::REG_WATCHDOG_PDI_COUNT;
      logic [15:0] time_q, left_q;
      logic [7:0] count_q;
      logic running_q, dead_q;
      assign expired[n] = running_q && unit && left_q == 16'd1 && !trigger[n];
      always_ff @(posedge clk_i or negedge rst_ni) begin
        if (!rst_ni) begin
          time_q    <= First;
          left_q    <= '0;
          count_q   <= '0;
          running_q <= 1'b0;
          dead_q    <= 1'b0;
        end else begin
          if (register_i.write && register_i.address == Time) time_q[7:0] <= register_i.data;
          if (register_i.write && register_i.address == Time + 12'd1) time_q[15:8] <= register_i.data;
          if (time_q == '0) begin
            running_q <= 1'b0;
            dead_q    <= 1'b0;
          end else if (trigger[n]) begin
            running_q <= 1'b1;
            dead_q    <= 1'b0;
            left_q    <= time_q;
          end else if (expired[n]) begin
            running_q <= 1'b0;
            dead_q    <= 1'b1;
          end else if (running_q && unit) begin
            left_q <= left_q - 1'b1;
          end
          if (register_i.write && register_i.address == Count) count_q <= '0;
          else if (expired[n] && count_q != '1) count_q <= count_q + 1'b1;
        end
      end
      assign alive[n]        = !dead_q;
      assign counts[8*n+:8]  = count_q;
    end
  endgenerate

  assign expired_o           = expired[0];
  assign application_alive_o = alive[1];

  always_comb begin
    live_hit_o  = 1'b1;
    live_data_o = '0;
    case (live_address_i)
      esc_regmap_pkg::REG_WATCHDOG_STATUS: live_data_o = 8'(alive[0]) << esc_regmap_pkg::WATCHDOG_STATUS_ALIVE_LSB;
      esc_regmap_pkg::REG_WATCHDOG_DATA_COUNT: live_data_o = counts[7:0];
      esc_regmap_pkg::REG_WATCHDOG_PDI_COUNT: live_data_o = counts[15:8];
      default: live_hit_o = 1'b0;
    endcase
  end

  logic unused;
  assign unused = &{register_i.read, register_i.application};

endmodule
