// SPDX-License-Identifier: Apache-2.0
// ecat_control: station address, data link control and status, states of the application layer, events.
// Contract: register_i is what happened a clock before. live_hit_o and live_data_o answer live_address_i at once, for
// registers that are not as they were last written. With device emulation AL_STATUS follows AL_CONTROL.
module ecat_control (
    input  logic clk_i,
    input  logic rst_ni,
    input  ecat_pkg::register_access_t register_i,
    input  logic [11:0] live_address_i,
    output logic        live_hit_o,
    output logic [7:0]  live_data_o,
    // SII
    input  logic        loaded_i,
    input  logic        alias_valid_i,
    input  logic [15:0] alias_i,
    // ports
    input  logic [1:0]  link_i,
    input  logic [1:0]  open_i,
    output logic [3:0]  loop_control_o,  // two bits a port
    output logic        loop_written_o,  // with the same or other bits
    // processing
    output logic [15:0] station_o,
    output logic [15:0] alias_o,
    output logic        alias_on_o,
    output logic        cut_foreign_o,   // frames of other types
    output logic [15:0] master_event_o,  // masked
    // events
    input  logic [7:0]  for_application_i,
    input  logic [7:0]  for_master_i,
    input  logic        sm_changed_i,
    input  logic        watchdog_expired_i,
    input  logic        watchdog_alive_i,
    input  logic [1:0]  sync_i,           // a pulse began
    input  logic        latch_i,          // an event lasts
    output logic        irq_o
);

  // Bytes of DL_CONTROL; those of both ports share one.
  localparam logic [11:0] LoopByte = esc_regmap_pkg::REG_DL_CONTROL + 12'(esc_regmap_pkg::DL_CONTROL_LOOP0_LSB / 8);
  localparam int unsigned Forwarding = esc_regmap_pkg::DL_CONTROL_FORWARDING_LSB;
  localparam int unsigned Alias = esc_regmap_pkg::DL_CONTROL_USE_ALIAS_LSB;
  localparam logic [11:0] AliasByte = esc_regmap_pkg::REG_DL_CONTROL + 12'(Alias / 8);
  localparam int unsigned State = esc_regmap_pkg::AL_CONTROL_STATE_LSB;
  localparam int unsigned StateWidth = esc_regmap_pkg::AL_CONTROL_STATE_WIDTH;

  logic [15:0] station_q, alias_q, master_mask_q, master_event;
  logic [31:0] event_mask_q, event_value;
  logic [3:0] loops_q;
  logic alias_on_q, cut_foreign_q, emulation_q, control_event_q, change_event_q, watchdog_event_q;
  logic [1:0] sync_event_q;
  logic [7:0] status_q;
  logic link_event_q, status_event_q, by_master, by_application, taken_by_application, taken_by_master;
  logic [3:0] lines_q;
  logic [15:0] dl_status;

  assign by_master            = register_i.write && !register_i.application;
  assign by_application       = register_i.write && register_i.application;
  assign taken_by_application = register_i.read && register_i.application;
  assign taken_by_master      = register_i.read && !register_i.application;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      station_q        <= '0;
      alias_q          <= '0;
      master_mask_q    <= '0;
      event_mask_q     <= '0;
      loops_q          <= '0;
      alias_on_q       <= 1'b0;
      cut_foreign_q    <= 1'b0;
      emulation_q      <= 1'b0;
      status_q         <= esc_regmap_pkg::RESET_AL_STATUS[7:0];
      control_event_q  <= 1'b0;
      change_event_q   <= 1'b0;
      watchdog_event_q <= 1'b0;
      sync_event_q     <= '0;
      link_event_q     <= 1'b0;
      status_event_q   <= 1'b0;
      lines_q          <= '0;
    end else begin
      if (alias_valid_i) alias_q <= alias_i;
      lines_q <= {link_i, open_i};
      if (sm_changed_i) change_event_q <= 1'b1;
      if (watchdog_expired_i) watchdog_event_q <= 1'b1;
      sync_event_q <= sync_event_q | sync_i;
      if (lines_q != {link_i, open_i}) link_event_q <= 1'b1;
      if (by_master) begin
        case (register_i.address)
          esc_regmap_pkg::REG_STATION_ADDRESS: station_q[7:0] <= register_i.data;
          esc_regmap_pkg::REG_STATION_ADDRESS + 12'd1: station_q[15:8] <= register_i.data;
          esc_regmap_pkg::REG_DL_CONTROL: cut_foreign_q <= register_i.data[Forwarding];
          LoopByte: loops_q <= {register_i.data[esc_regmap_pkg::DL_CONTROL_LOOP1_LSB%8+:2],
                                register_i.data[esc_regmap_pkg::DL_CONTROL_LOOP0_LSB%8+:2]};
          AliasByte: alias_on_q <= register_i.data[Alias%8];
          esc_regmap_pkg::REG_MASTER_EVENT_MASK: master_mask_q[7:0] <= register_i.data;
          esc_regmap_pkg::REG_MASTER_EVENT_MASK + 12'd1: master_mask_q[15:8] <= register_i.data;
          esc_regmap_pkg::REG_AL_CONTROL: begin
            if (emulation_q) begin
              status_q       <= 8'(register_i.data[State+:StateWidth]) << esc_regmap_pkg::AL_STATUS_STATE_LSB;
              status_event_q <= 1'b1;
            end else begin
              control_event_q <= 1'b1;
            end
          end
          default: ;
        endcase
      end
      if (by_application) begin
        case (register_i.address)
          esc_regmap_pkg::REG_AL_STATUS: begin
            status_q       <= register_i.data;
            status_event_q <= 1'b1;
          end
          esc_regmap_pkg::REG_PDI_CONFIG: emulation_q <= register_i.data[esc_regmap_pkg::PDI_CONFIG_EMULATION_LSB];
          esc_regmap_pkg::REG_AL_EVENT_MASK: event_mask_q[7:0] <= register_i.data;
          esc_regmap_pkg::REG_AL_EVENT_MASK + 12'd1: event_mask_q[15:8] <= register_i.data;
          default: ;
        endcase
      end
      if (taken_by_application) begin
        if (register_i.address == esc_regmap_pkg::REG_AL_CONTROL) control_event_q <= 1'b0;
        if (register_i.address == esc_regmap_pkg::REG_WATCHDOG_STATUS) watchdog_event_q <= 1'b0;
        if (register_i.address == esc_regmap_pkg::REG_SYNC_STATUS_0) sync_event_q[0] <= 1'b0;
        if (register_i.address == esc_regmap_pkg::REG_SYNC_STATUS_1) sync_event_q[1] <= 1'b0;
        if (register_i.address[11:6] == esc_regmap_pkg::REG_SM_ACTIVATE[11:6]
            && register_i.address[2:0] == esc_regmap_pkg::REG_SM_ACTIVATE[2:0])
          change_event_q <= 1'b0;
      end
      if (taken_by_master) begin
        if (register_i.address == esc_regmap_pkg::REG_DL_STATUS) link_event_q <= 1'b0;
        if (register_i.address == esc_regmap_pkg::REG_AL_STATUS) status_event_q <= 1'b0;
      end
    end
  end

  always_comb begin
    event_value = '0;
    event_value[esc_regmap_pkg::AL_EVENT_AL_CONTROL_LSB] = control_event_q;
    event_value[esc_regmap_pkg::AL_EVENT_LATCH_LSB]      = latch_i;
    event_value[esc_regmap_pkg::AL_EVENT_SYNC0_LSB]      = sync_event_q[0];
    event_value[esc_regmap_pkg::AL_EVENT_SYNC1_LSB]      = sync_event_q[1];
    event_value[esc_regmap_pkg::AL_EVENT_SM_CHANGE_LSB]  = change_event_q;
    event_value[esc_regmap_pkg::AL_EVENT_WATCHDOG_LSB]   = watchdog_event_q;
    event_value[esc_regmap_pkg::AL_EVENT_SM_LSB+:8]      = for_application_i;
    master_event = '0;
    master_event[esc_regmap_pkg::MASTER_EVENT_LATCH_LSB]     = latch_i;
    master_event[esc_regmap_pkg::MASTER_EVENT_DL_STATUS_LSB] = link_event_q;
    master_event[esc_regmap_pkg::MASTER_EVENT_AL_STATUS_LSB] = status_event_q;
    master_event[esc_regmap_pkg::MASTER_EVENT_SM_LSB+:8]     = for_master_i;
    dl_status = esc_regmap_pkg::RESET_DL_STATUS;
    dl_status[esc_regmap_pkg::DL_STATUS_OPERATIONAL_LSB]    = loaded_i;
    dl_status[esc_regmap_pkg::DL_STATUS_WATCHDOG_LSB]       = watchdog_alive_i;
    dl_status[esc_regmap_pkg::DL_STATUS_LINK_LSB+:2]        = link_i;
    dl_status[esc_regmap_pkg::DL_STATUS_LOOP0_LSB]          = !open_i[0];
    dl_status[esc_regmap_pkg::DL_STATUS_COMMUNICATION0_LSB] = link_i[0] && open_i[0];
    dl_status[esc_regmap_pkg::DL_STATUS_LOOP1_LSB]          = !open_i[1];
    dl_status[esc_regmap_pkg::DL_STATUS_COMMUNICATION1_LSB] = link_i[1] && open_i[1];
  end

  always_comb begin
    live_hit_o  = 1'b1;
    live_data_o = '0;
    case (live_address_i)
      esc_regmap_pkg::REG_REGISTER_ENABLE, esc_regmap_pkg::REG_WRITE_ENABLE: live_data_o = '0;
      esc_regmap_pkg::REG_STATION_ALIAS: live_data_o = alias_q[7:0];
      esc_regmap_pkg::REG_STATION_ALIAS + 12'd1: live_data_o = alias_q[15:8];
      esc_regmap_pkg::REG_DL_STATUS: live_data_o = dl_status[7:0];
      esc_regmap_pkg::REG_DL_STATUS + 12'd1: live_data_o = dl_status[15:8];
      esc_regmap_pkg::REG_AL_STATUS: live_data_o = status_q;
      esc_regmap_pkg::REG_MASTER_EVENT: live_data_o = master_event[7:0];
      esc_regmap_pkg::REG_MASTER_EVENT + 12'd1: live_data_o = master_event[15:8];
      esc_regmap_pkg::REG_AL_EVENT: live_data_o = event_value[7:0];
      esc_regmap_pkg::REG_AL_EVENT + 12'd1: live_data_o = event_value[15:8];
      default: live_hit_o = 1'b0;
    endcase
  end

  assign station_o      = station_q;
  assign alias_o        = alias_q;
  assign alias_on_o     = alias_on_q;
  assign cut_foreign_o  = cut_foreign_q;
  assign loop_control_o = loops_q;
  assign loop_written_o = by_master && register_i.address == LoopByte;
  assign master_event_o = master_event & master_mask_q;
  assign irq_o          = (event_value & event_mask_q) != '0;

endmodule
