// SPDX-License-Identifier: Apache-2.0
// ecat_control_sva: events stay until their side takes them, and only the master moves the station.
module ecat_control_sva (
    input logic clk_i,
    input logic rst_ni,
    input ecat_pkg::register_access_t register_i,
    input logic alias_valid_i,
    input logic [31:0] event_value,
    input logic [15:0] master_event,
    input logic emulation_q,
    input logic [7:0] status_q,
    input logic [15:0] station_o,
    input logic [15:0] alias_o
);

  localparam logic [31:0] Managers = 32'hff << esc_regmap_pkg::AL_EVENT_SM_LSB;
  localparam logic [15:0] MasterManagers = 16'hff << esc_regmap_pkg::MASTER_EVENT_SM_LSB;

  // Of others: the latch inputs (ecat_latch) and the sync managers.
  localparam logic [31:0] Others = Managers | 32'd1 << esc_regmap_pkg::AL_EVENT_LATCH_LSB;
  localparam logic [15:0] MasterOthers = MasterManagers | 16'd1 << esc_regmap_pkg::MASTER_EVENT_LATCH_LSB;

  logic [esc_regmap_pkg::AL_CONTROL_STATE_WIDTH-1:0] asked;  // a state
  assign asked = register_i.data[esc_regmap_pkg::AL_CONTROL_STATE_LSB+:esc_regmap_pkg::AL_CONTROL_STATE_WIDTH];

  logic [31:0] event_q, gone;
  logic [15:0] master_q, master_gone;
  assign gone        = event_q & ~event_value;
  assign master_gone = master_q & ~master_event;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      event_q  <= '0;
      master_q <= '0;
    end else begin
      event_q  <= event_value;
      master_q <= master_event;
    end
  end

  EventStands : assert property (@(posedge clk_i) disable iff (!rst_ni)
      (gone & ~Others) != '0 |-> $past(register_i.read && register_i.application))
  else $error("an event of the application went without its read");

  MasterEventStands : assert property (@(posedge clk_i) disable iff (!rst_ni)
      (master_gone & ~MasterOthers) != '0 |-> $past(register_i.read && !register_i.application))
  else $error("an event of the master went without its read");

  StationOfTheMaster : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $past(rst_ni) && !$stable(station_o) |-> $past(register_i.write && !register_i.application))
  else $error("the station address changed without the master");

  AliasOfTheSii : assert property (@(posedge clk_i) disable iff (!rst_ni)
      $past(rst_ni) && !$stable(alias_o) |-> $past(alias_valid_i))
  else $error("the station alias is not that of the SII");

  EmulationFollows : assert property (@(posedge clk_i) disable iff (!rst_ni)
      emulation_q && register_i.write && !register_i.application
      && register_i.address == esc_regmap_pkg::REG_AL_CONTROL
      |=> status_q == $past(8'(asked) << esc_regmap_pkg::AL_STATUS_STATE_LSB))
  else $error("AL_STATUS does not follow AL_CONTROL");

endmodule

bind ecat_control ecat_control_sva u_sva (.*);
