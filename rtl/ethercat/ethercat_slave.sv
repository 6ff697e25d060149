// SPDX-License-Identifier: Apache-2.0
// ethercat_slave: EtherCAT-compatible slave controller with two MII ports. Registers: regmap.rdl, docs/ethercat.md.
// "EtherCAT" is a trade mark of its owner; no conformance test was run.
// Contract: clk_i is 100 MHz. mii_tick_i is high one clock in four: in that clock a nibble leaves at mii_tx_*; the PHYs' TX_CLK
// has that period. Frames are forwarded as they pass, with constant delay. The application's port is in regmap.rdl.
// reset_no is low while the controller is reset, by rst_ni or as the master asked for; it resets the application.
// Latches = 0 leaves the latch inputs out: their registers are 0.
module ethercat_slave #(
    parameter int unsigned SiiWords = 2048,
    parameter int unsigned Latches  = 1
) (
    input  logic        clk_i,
    input  logic        rst_ni,
    // MII, port n at bit n (nibble n)
    input  logic        mii_tick_i,
    input  logic [1:0]  link_i,
    input  logic [1:0]  mii_rx_clk_i,
    input  logic [1:0]  mii_rx_dv_i,
    input  logic [1:0]  mii_rx_er_i,
    input  logic [7:0]  mii_rxd_i,
    output logic [1:0]  mii_tx_en_o,
    output logic [7:0]  mii_txd_o,
    // application, Avalon-MM
    input  logic [13:0] avs_address_i,  // words
    input  logic        avs_read_i,
    input  logic        avs_write_i,
    input  logic [3:0]  avs_byteenable_i,
    input  logic [31:0] avs_writedata_i,
    output logic [31:0] avs_readdata_o,
    output logic        avs_waitrequest_o,
    output logic        irq_o,
    output logic        reset_no,
    // distributed clocks
    input  logic [1:0]  latch_i,
    output logic [1:0]  sync_o,
    output logic [63:0] time_o
);

  logic rst_n;  // of everything but ecat_reset

  ecat_pkg::nibble_t receive_0, receive_1, to_unit, from_unit, send_0, send_1;
  logic [1:0] start, link_meta_q, link_q, open, lost;
  logic [3:0] loop_control;
  logic looped, loop_written;

  always_ff @(posedge clk_i or negedge rst_n) begin
    if (!rst_n) begin
      link_meta_q <= '0;
      link_q      <= '0;
    end else begin
      link_meta_q <= link_i;
      link_q      <= link_meta_q;
    end
  end

  mii_receive u_receive_0 (
      .clk_i,
      .rst_ni        (rst_n),
      .tick_i     (mii_tick_i),
      .mii_clk_i  (mii_rx_clk_i[0]),
      .mii_valid_i(mii_rx_dv_i[0] && link_q[0]),
      .mii_error_i(mii_rx_er_i[0]),
      .mii_data_i (mii_rxd_i[3:0]),
      .start_o    (start[0]),
      .nibble_o   (receive_0)
  );
  mii_receive u_receive_1 (
      .clk_i,
      .rst_ni        (rst_n),
      .tick_i     (mii_tick_i),
      .mii_clk_i  (mii_rx_clk_i[1]),
      .mii_valid_i(mii_rx_dv_i[1] && link_q[1]),
      .mii_error_i(mii_rx_er_i[1]),
      .mii_data_i (mii_rxd_i[7:4]),
      .start_o    (start[1]),
      .nibble_o   (receive_1)
  );

  ecat_ports u_ports (
      .clk_i,
      .rst_ni        (rst_n),
      .tick_i     (mii_tick_i),
      .link_i     (link_q),
      .control_i  (loop_control),
      .anew_i     (loop_written),
      .open_o     (open),
      .looped_o   (looped),
      .lost_o     (lost),
      .receive_0_i(receive_0),
      .receive_1_i(receive_1),
      .to_unit_o  (to_unit),
      .from_unit_i(from_unit),
      .send_0_o   (send_0),
      .send_1_o   (send_1)
  );

  logic [1:0] tx_en_q;
  logic [7:0] txd_q;
  always_ff @(posedge clk_i or negedge rst_n) begin
    if (!rst_n) begin
      tx_en_q <= '0;
      txd_q   <= '0;
    end else if (mii_tick_i) begin
      tx_en_q <= {send_1.valid, send_0.valid};
      txd_q   <= {send_1.data, send_0.data};
    end
  end
  assign mii_tx_en_o = tx_en_q;
  assign mii_txd_o   = txd_q;

  // Frames.
  logic frame_start, byte_valid, frame_end, frame_bad, good, destroy, received, bad, marked, unit_error;
  logic malformed, destroyed_q;
  logic [7:0] data, result;
  ecat_unit u_unit (
      .clk_i,
      .rst_ni        (rst_n),
      .tick_i       (mii_tick_i),
      .nibble_i     (to_unit),
      .nibble_o     (from_unit),
      .frame_start_o(frame_start),
      .byte_valid_o (byte_valid),
      .byte_o       (data),
      .result_i     (result),
      .destroy_i    (destroy),
      .looped_i     (looped),
      .spoilt_i     (malformed || destroyed_q),
      .frame_end_o  (frame_end),
      .frame_bad_o  (frame_bad),
      .frame_good_o (good),
      .received_o   (received),
      .bad_o        (bad),
      .marked_o     (marked),
      .error_o      (unit_error)
  );

  // What comes back on port 1 is only looked at.
  logic back_body, back_odd, back_end, back_bad, back_marked, back_error;
  ecat_check u_back (
      .clk_i,
      .rst_ni        (rst_n),
      .tick_i  (mii_tick_i),
      .nibble_i(receive_1),
      .body_o  (back_body),
      .odd_o   (back_odd),
      .end_o   (back_end),
      .bad_o   (back_bad),
      .marked_o(back_marked),
      .error_o (back_error)
  );

  // Datagrams.
  logic foreign, ready, busy, over, alias_on, cut_foreign;
  logic [15:0] station, station_alias, master_event;
  logic request, logical, read, write, read_done, write_done;
  logic [31:0] address;
  logic [7:0] write_data, read_data, read_mask;
  ecat_datagrams u_datagrams (
      .clk_i,
      .rst_ni        (rst_n),
      .frame_start_i(frame_start),
      .byte_valid_i (byte_valid),
      .byte_i       (data),
      .result_o     (result),
      .malformed_o  (malformed),
      .foreign_o    (foreign),
      .serve_i      (ready && !busy),
      .station_i    (station),
      .alias_i      (station_alias),
      .alias_on_i   (alias_on),
      .event_i      (master_event),
      .looped_i     (looped),
      .cut_foreign_i(cut_foreign),
      .destroy_o    (destroy),
      .request_o    (request),
      .logical_o    (logical),
      .address_o    (address),
      .read_o       (read),
      .write_o      (write),
      .data_o       (write_data),
      .read_data_i  (read_data),
      .read_mask_i  (read_mask),
      .read_done_i  (read_done),
      .write_done_i (write_done)
  );

  always_ff @(posedge clk_i or negedge rst_n) begin
    if (!rst_n) destroyed_q <= 1'b0;
    else if (frame_start) destroyed_q <= 1'b0;
    else if (destroy) destroyed_q <= 1'b1;
  end

  // Writes of good frames.
  logic push, commit_valid, commit_ready, done, faulty;
  ecat_pkg::log_t entry, commit_entry;
  logic [ecat_pkg::LOG_WIDTH-1:0] commit_bits;
  assign faulty = !frame_bad && (malformed || over || destroyed_q) && !foreign;
  ecat_write_log u_log (
      .clk_i,
      .rst_ni        (rst_n),
      .clear_i (frame_start),
      .push_i  (push),
      .entry_i (entry),
      .commit_i(good),
      .drop_o  (over),
      .busy_o  (busy),
      .done_o  (done),
      .valid_o (commit_valid),
      .entry_o (commit_bits),
      .ready_i (commit_ready)
  );
  assign commit_entry = commit_bits;

  // Bytes.
  ecat_pkg::register_access_t register_access;
  logic app_valid, app_write, app_ready, app_done, app_denied;
  logic [15:0] app_address;
  logic [7:0] app_write_data, app_read_data;
  logic [11:0] live_address;
  logic live_application, live_read, live_hit_q;
  logic [7:0] live_data_q;
  logic [8*ecat_pkg::SYNC_MANAGERS-1:0] sm_status;
  logic [ecat_pkg::SYNC_MANAGERS-1:0] for_application, for_master;
  logic sm_changed, watchdog_trigger;
  ecat_access u_access (
      .clk_i,
      .rst_ni        (rst_n),
      .ready_o           (ready),
      .frame_start_i     (frame_start),
      .byte_valid_i      (byte_valid),
      .request_i         (request),
      .logical_i         (logical),
      .address_i         (address),
      .read_i            (read),
      .write_i           (write),
      .data_i            (write_data),
      .read_data_o       (read_data),
      .read_mask_o       (read_mask),
      .read_done_o       (read_done),
      .write_done_o      (write_done),
      .push_o            (push),
      .entry_o           (entry),
      .commit_valid_i    (commit_valid),
      .commit_i          (commit_entry),
      .commit_ready_o    (commit_ready),
      .app_valid_i       (app_valid),
      .app_write_i       (app_write),
      .app_address_i     (app_address),
      .app_data_i        (app_write_data),
      .app_ready_o       (app_ready),
      .app_done_o        (app_done),
      .app_data_o        (app_read_data),
      .app_denied_o      (app_denied),
      .register_o        (register_access),
      .live_address_o    (live_address),
      .live_application_o(live_application),
      .live_read_o       (live_read),
      .live_hit_i        (live_hit_q),
      .live_data_i       (live_data_q),
      .status_o          (sm_status),
      .for_application_o (for_application),
      .for_master_o      (for_master),
      .sm_changed_o      (sm_changed),
      .watchdog_o        (watchdog_trigger)
  );

  logic sii_read, sii_write, sii_ready;
  logic [7:0] sii_data;
  ecat_application u_application (
      .clk_i,
      .rst_ni        (rst_n),
      .avs_address_i,
      .avs_read_i,
      .avs_write_i,
      .avs_byteenable_i,
      .avs_writedata_i,
      .avs_readdata_o,
      .avs_waitrequest_o,
      .valid_o    (app_valid),
      .write_o    (app_write),
      .address_o  (app_address),
      .data_o     (app_write_data),
      .ready_i    (app_ready),
      .done_i     (app_done),
      .data_i     (app_read_data),
      .sii_read_o (sii_read),
      .sii_write_o(sii_write),
      .sii_data_i (sii_data),
      .sii_ready_i(sii_ready)
  );

  // Registers that live; each answers with a hit, and only one does.
  logic [7:0] hits;
  logic [7:0] control_data, counter_data, watchdog_data, sii_live, clock_data, sync_data, reset_data, latch_data;
  logic [7:0] sm_data, live_data;
  logic sm_hit, loaded, alias_valid, expired, alive, latch_event;
  logic [15:0] alias_read;
  logic [1:0] sync_begins;

  ecat_control u_control (
      .clk_i,
      .rst_ni        (rst_n),
      .register_i        (register_access),
      .live_address_i    (live_address),
      .live_hit_o        (hits[0]),
      .live_data_o       (control_data),
      .loaded_i          (loaded),
      .alias_valid_i     (alias_valid),
      .alias_i           (alias_read),
      .link_i            (link_q),
      .open_i            (open),
      .loop_control_o    (loop_control),
      .loop_written_o    (loop_written),
      .station_o         (station),
      .alias_o           (station_alias),
      .alias_on_o        (alias_on),
      .cut_foreign_o     (cut_foreign),
      .master_event_o    (master_event),
      .for_application_i (for_application),
      .for_master_i      (for_master),
      .sm_changed_i      (sm_changed),
      .watchdog_expired_i(expired),
      .watchdog_alive_i  (alive),
      .sync_i            (sync_begins),
      .latch_i           (latch_event),
      .irq_o
  );

  // The port that the processing unit hears, and the way back.
  logic unit_bad, unit_marked, way_back;
  assign unit_bad    = received && bad;
  assign unit_marked = marked;
  assign way_back    = mii_tick_i && back_end && !looped;
  ecat_counters u_counters (
      .clk_i,
      .rst_ni        (rst_n),
      .register_i    (register_access),
      .live_address_i(live_address),
      .live_hit_o    (hits[1]),
      .live_data_o   (counter_data),
      .count_i       ({
          lost,
          app_done && app_denied,
          frame_end && faulty,
          (way_back && back_bad && back_marked) || (looped && unit_bad && unit_marked),
          !looped && unit_bad && unit_marked,
          (way_back && back_error) || (looped && received && unit_error),
          (way_back && back_bad && !back_marked) || (looped && unit_bad && !unit_marked),
          !looped && received && unit_error,
          !looped && unit_bad && !unit_marked
      })
  );

  ecat_watchdog u_watchdog (
      .clk_i,
      .rst_ni        (rst_n),
      .register_i           (register_access),
      .live_address_i       (live_address),
      .live_hit_o           (hits[2]),
      .live_data_o          (watchdog_data),
      .data_trigger_i       (watchdog_trigger),
      .application_trigger_i(app_done),
      .expired_o            (expired),
      .application_alive_o  (alive)
  );

  ecat_sii #(
      .Words(SiiWords)
  ) u_sii (
      .clk_i,
      .rst_ni        (rst_n),
      .register_i    (register_access),
      .idle_i        (!busy),
      .live_address_i(live_address),
      .live_hit_o    (hits[3]),
      .live_data_o   (sii_live),
      .app_write_i   (sii_write),
      .app_address_i (app_address[$clog2(2*SiiWords)-1:0]),
      .app_data_i    (app_write_data),
      .app_read_i    (sii_read),
      .app_data_o    (sii_data),
      .app_ready_o   (sii_ready),
      .loaded_o      (loaded),
      .alias_valid_o (alias_valid),
      .alias_o       (alias_read)
  );

  ecat_clock u_clock (
      .clk_i,
      .rst_ni        (rst_n),
      .register_i        (register_access),
      .live_address_i    (live_address),
      .live_application_i(live_application),
      .live_read_i       (live_read),
      .live_hit_o        (hits[4]),
      .live_data_o       (clock_data),
      .start_i           (start),
      .looped_i          (looped),
      .frame_end_i       (frame_end),
      .done_i            (done),
      .time_o
  );

  ecat_sync_pulses u_sync_pulses (
      .clk_i,
      .rst_ni        (rst_n),
      .register_i    (register_access),
      .done_i        (done),
      .live_address_i(live_address),
      .live_hit_o    (hits[5]),
      .live_data_o   (sync_data),
      .time_i        (time_o),
      .begins_o      (sync_begins),
      .sync_o
  );

  ecat_reset u_reset (
      .clk_i,
      .rst_ni,
      .register_i    (register_access),
      .done_i        (done),
      .live_address_i(live_address),
      .live_hit_o    (hits[6]),
      .live_data_o   (reset_data),
      .reset_no      (rst_n)
  );
  assign reset_no = rst_n;

  generate
    if (Latches != 0) begin : gen_latch
      ecat_latch u_latch (
          .clk_i,
          .rst_ni            (rst_n),
          .register_i        (register_access),
          .live_address_i    (live_address),
          .live_application_i(live_application),
          .live_read_i       (live_read),
          .live_hit_o        (hits[7]),
          .live_data_o       (latch_data),
          .time_i            (time_o),
          .latch_i,
          .event_o           (latch_event)
      );
    end else begin : gen_no_latch
      logic unused_latch;
      assign {hits[7], latch_data, latch_event} = '0;
      assign unused_latch = &{latch_i, live_read};
    end
  endgenerate

  // Sync managers: STATUS.
  assign sm_hit  = live_address[11:6] == esc_regmap_pkg::REG_SM_STATUS[11:6]
                   && live_address[2:0] == esc_regmap_pkg::REG_SM_STATUS[2:0];
  assign sm_data = sm_status[8*live_address[5:3]+:8];

  always_comb begin
    live_data = '0;
    if (hits[0]) live_data = live_data | control_data;
    if (hits[1]) live_data = live_data | counter_data;
    if (hits[2]) live_data = live_data | watchdog_data;
    if (hits[3]) live_data = live_data | sii_live;
    if (hits[4]) live_data = live_data | clock_data;
    if (hits[5]) live_data = live_data | sync_data;
    if (hits[6]) live_data = live_data | reset_data;
    if (hits[7]) live_data = live_data | latch_data;
    if (sm_hit) live_data = live_data | sm_data;
  end
  always_ff @(posedge clk_i) begin
    live_hit_q  <= hits != '0 || sm_hit;
    live_data_q <= live_data;
  end

  logic unused;
  assign unused = &{back_body, back_odd, send_0.error, send_1.error};

endmodule
