// SPDX-License-Identifier: Apache-2.0
// ecat_access: the one way to the controller's bytes, a byte (or a window of bits) a clock.
// A passing frame goes first, then what good frames have left to write, then the application.
// Contract, in clocks behind a frame's byte_valid_i: 1 to 8 its accesses enter, one an FMMU; 14 what they read is
// complete at read_data_o. An access enters, is mapped (2), guarded by sync managers (2) and done (2). A write of some
// bits of a byte reads it first: behind another access it enters a clock later.
module ecat_access (
    input  logic clk_i,
    input  logic rst_ni,
    output logic ready_o,   // registers have their reset values; nothing is served before
    // a frame as it passes
    input  logic        byte_valid_i,
    input  logic        request_i,
    input  logic        logical_i,
    input  logic [31:0] address_i,
    input  logic        read_i,
    input  logic        write_i,
    input  logic [7:0]  data_i,
    output logic [7:0]  read_data_o,
    output logic [7:0]  read_mask_o,
    output logic        read_done_o,
    output logic        write_done_o,
    // to the log and back
    output logic        push_o,
    output ecat_pkg::log_t entry_o,
    input  logic        commit_valid_i,
    input  ecat_pkg::log_t commit_i,
    output logic        commit_ready_o,
    // application
    input  logic        app_valid_i,
    input  logic        app_write_i,
    input  logic [15:0] app_address_i,
    input  logic [7:0]  app_data_i,
    output logic        app_ready_o,
    output logic        app_done_o,      // of a read or write taken 6 clocks before
    output logic [7:0]  app_data_o,
    output logic        app_denied_o,    // with app_done_o
    // registers
    output ecat_pkg::register_access_t register_o,
    output logic [11:0] live_address_o,
    output logic        live_application_o,
    input  logic        live_hit_i,      // a clock behind live_address_o
    input  logic [7:0]  live_data_i,
    // sync managers
    output logic [8*ecat_pkg::SYNC_MANAGERS-1:0] status_o,
    output logic [ecat_pkg::SYNC_MANAGERS-1:0] for_application_o,
    output logic [ecat_pkg::SYNC_MANAGERS-1:0] application_done_o,
    output logic [ecat_pkg::SYNC_MANAGERS-1:0] for_master_o,
    output logic [ecat_pkg::SYNC_MANAGERS-1:0] master_done_o,
    output logic        sm_changed_o,
    output logic        watchdog_o
);

  localparam logic [3:0] MemoryEnd = 4'h3;  // 0x3000

  // Enter.
  logic        running_q, logical_q, read_q, write_q, sweep_q, entered_q, frame_slot, partial;
  logic [2:0]  slot_q;
  logic [31:0] address_q;
  logic [7:0]  data_q;
  logic [11:0] sweep_address_q;
  ecat_pkg::access_t entering, access_1_q, access_2_q, access_3_q, access_4_q, access_5_q, guarded;
  ecat_pkg::window_t window, window_1_q, window_2_q, window_3_q, window_4_q, window_5_q, mapped, fmmu_window;
  logic        logical_1_q, logical_2_q, fmmu_read, fmmu_write;
  logic [5:0]  begin_q;   // slot 0 on its way

  assign frame_slot = running_q && (logical_q || slot_q == '0);
  assign partial    = commit_i.write && (commit_i.window.mask != '1 || commit_i.window.shift != '0);
  assign commit_ready_o = !frame_slot && !(partial && entered_q);
  assign app_ready_o    = !frame_slot && !commit_valid_i && !sweep_q;

  always_comb begin
    entering = '0;
    window = '0;
    window.mask = '1;
    if (frame_slot) begin
      entering.valid = 1'b1;
      entering.frame = 1'b1;
      entering.read  = read_q;
      entering.write = write_q;
      entering.data  = data_q;
      window.address = address_q[15:0];
    end else if (commit_valid_i) begin
      entering.valid  = commit_ready_o;
      entering.commit = 1'b1;
      entering.read   = commit_i.read;
      entering.write  = commit_i.write;
      entering.data   = commit_i.data;
      window          = commit_i.window;
    end else begin
      entering.valid       = app_valid_i && app_ready_o;
      entering.application = 1'b1;
      entering.read        = !app_write_i;
      entering.write       = app_write_i;
      entering.data        = app_data_i;
      window.address       = app_address_i;
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      running_q <= 1'b0;
      slot_q    <= '0;
      begin_q   <= '0;
      entered_q <= 1'b0;
    end else begin
      begin_q   <= {begin_q[4:0], byte_valid_i};
      entered_q <= entering.valid;
      if (byte_valid_i) begin
        running_q <= request_i;
        slot_q    <= '0;
      end else begin
        slot_q <= slot_q + 1'b1;
        if (slot_q == '1) running_q <= 1'b0;
      end
    end
  end
  always_ff @(posedge clk_i) begin
    if (byte_valid_i) begin
      logical_q <= logical_i;
      address_q <= address_i;
      read_q    <= read_i;
      write_q   <= write_i;
      data_q    <= data_i;
    end
  end

  // Map: two clocks.
  ecat_fmmus u_fmmus (
      .clk_i, .rst_ni,
      .register_i(register_o),
      .slot_i    (slot_q),
      .address_i (address_q),
      .window_o  (fmmu_window),
      .read_o    (fmmu_read),
      .write_o   (fmmu_write)
  );

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      access_1_q <= '0;
      access_2_q <= '0;
      access_3_q <= '0;
    end else begin
      access_1_q <= entering;
      access_2_q <= access_1_q;
      access_3_q <= guarded;
    end
  end
  always_ff @(posedge clk_i) begin
    window_1_q  <= window;
    logical_1_q <= logical_q && frame_slot;
    window_2_q  <= window_1_q;
    logical_2_q <= logical_1_q;
    window_3_q  <= mapped;
  end

  always_comb begin
    guarded = access_2_q;
    mapped  = window_2_q;
    if (logical_2_q) begin
      mapped        = fmmu_window;
      guarded.read  = access_2_q.read && fmmu_read;
      guarded.write = access_2_q.write && fmmu_write;
    end
  end

  // Guard: two clocks.
  logic        sm_read, sm_write, sm_ends, is_register, exists, may_read, may_write, asked;
  logic [15:0] sm_address, address_4_q, address_5_q;
  ecat_sync_managers u_sync_managers (
      .clk_i, .rst_ni,
      .register_i(register_o),
      .status_o,
      .access_i  (guarded),
      .window_i  (mapped),
      .read_o    (sm_read),
      .write_o   (sm_write),
      .ends_o    (sm_ends),
      .address_o (sm_address),
      .for_application_o,
      .application_done_o,
      .for_master_o,
      .master_done_o,
      .changed_o (sm_changed_o),
      .watchdog_o
  );

  assign is_register = window_3_q.address[15:12] == '0;
  assign exists      = window_3_q.address[15:12] < MemoryEnd && sm_address[15:12] < MemoryEnd;
  assign may_read    = access_3_q.valid && access_3_q.read && sm_read && exists;
  assign may_write   = access_3_q.valid && access_3_q.write && sm_write && exists
                       && (!is_register || (access_3_q.application
                           ? esc_regmap_pkg::application_writes(window_3_q.address[11:0])
                           : esc_regmap_pkg::master_writes(window_3_q.address[11:0])));
  assign asked       = access_3_q.valid && (access_3_q.read || access_3_q.write);

  always_comb begin
    entry_o        = '0;
    entry_o.read   = may_read && (sm_ends || window_3_q.address == {4'd0, esc_regmap_pkg::REG_DL_STATUS}
                                  || window_3_q.address == {4'd0, esc_regmap_pkg::REG_AL_STATUS});
    entry_o.write  = may_write;
    entry_o.data   = access_3_q.data;
    entry_o.window = window_3_q;
  end
  assign push_o = access_3_q.frame && (entry_o.read || entry_o.write);

  logic denied_4_q, denied_5_q;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      access_4_q <= '0;
      access_5_q <= '0;
      denied_4_q <= 1'b0;
      denied_5_q <= 1'b0;
    end else begin
      access_4_q       <= access_3_q;
      access_4_q.read  <= may_read;
      access_4_q.write <= may_write;
      access_5_q       <= access_4_q;
      denied_4_q       <= asked && !may_read && !may_write;
      denied_5_q       <= denied_4_q;
    end
  end
  always_ff @(posedge clk_i) begin
    window_4_q  <= window_3_q;
    address_4_q <= sm_address;
    window_5_q  <= window_4_q;
    address_5_q <= address_4_q;
  end

  // Read, change, write.
  logic [15:0] stored, held, mask, fresh, merged, wide_mask, wide_data;
  logic [7:0]  first, byte_read;
  logic [1:0]  store;
  logic        live_5_q;

  assign live_address_o     = window_4_q.address[11:0];
  assign live_application_o = access_4_q.application;
  always_ff @(posedge clk_i) live_5_q <= window_4_q.address[15:12] == '0;

  ecat_memory u_memory (
      .clk_i,
      .read_address_i (address_4_q[13:0]),
      .read_data_o    (stored),
      .write_i        (sweep_q ? 2'b01 : store),
      .write_address_i(sweep_q ? {2'd0, sweep_address_q} : address_5_q[13:0]),
      .write_data_i   (sweep_q ? {8'd0, esc_regmap_pkg::reset_byte(sweep_address_q)} : merged)
  );

  assign first     = live_5_q && live_hit_i ? live_data_i : stored[7:0];
  assign held      = window_5_q.high ? {first, 8'd0} : {stored[15:8], first};
  assign byte_read = 8'(held >> window_5_q.shift) & window_5_q.mask;
  assign wide_mask = {8'd0, window_5_q.mask} << window_5_q.shift;
  assign wide_data = {8'd0, access_5_q.data} << window_5_q.shift;
  assign mask      = window_5_q.high ? {8'd0, wide_mask[15:8]} : wide_mask;
  assign fresh     = window_5_q.high ? {8'd0, wide_data[15:8]} : wide_data;
  assign merged    = ({stored[15:8], first} & ~mask) | (fresh & mask);
  assign store     = {2{access_5_q.valid && access_5_q.write && !access_5_q.frame}} & {mask[15:8] != '0, mask[7:0] != '0};

  ecat_pkg::register_access_t register_q;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      register_q <= '0;
    end else begin
      register_q.write       <= store[0] && live_5_q;
      register_q.read        <= access_5_q.valid && access_5_q.read && !access_5_q.frame && live_5_q;
      register_q.application <= access_5_q.application;
      register_q.address     <= window_5_q.address[11:0];
      register_q.data        <= merged[7:0];
    end
  end
  assign register_o = register_q;

  // What a frame's byte read, over all FMMUs.
  logic [7:0] read_data_q, read_mask_q;
  logic       read_done_q, write_done_q, seen;
  assign seen = access_5_q.valid && access_5_q.frame;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      read_data_q  <= '0;
      read_mask_q  <= '0;
      read_done_q  <= 1'b0;
      write_done_q <= 1'b0;
    end else begin
      read_data_q  <= (begin_q[5] ? '0 : read_data_q) | (seen && access_5_q.read ? byte_read : '0);
      read_mask_q  <= (begin_q[5] ? '0 : read_mask_q) | (seen && access_5_q.read ? window_5_q.mask : '0);
      read_done_q  <= (!begin_q[5] && read_done_q) || (seen && access_5_q.read);
      write_done_q <= (!begin_q[5] && write_done_q) || (seen && access_5_q.write);
    end
  end
  assign read_data_o  = read_data_q;
  assign read_mask_o  = read_mask_q;
  assign read_done_o  = read_done_q;
  assign write_done_o = write_done_q;

  assign app_done_o   = access_5_q.valid && access_5_q.application;
  assign app_data_o   = access_5_q.read ? byte_read : '0;
  assign app_denied_o = denied_5_q;

  logic unused;
  assign unused = &{access_5_q.commit, address_5_q[15:14]};

  // Behind reset every register's byte gets its value.
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      sweep_q         <= 1'b1;
      sweep_address_q <= '0;
    end else if (sweep_q) begin
      sweep_address_q <= sweep_address_q + 1'b1;
      if (sweep_address_q == '1) sweep_q <= 1'b0;
    end
  end
  assign ready_o = !sweep_q;

endmodule
