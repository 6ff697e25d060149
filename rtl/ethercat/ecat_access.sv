// SPDX-License-Identifier: Apache-2.0
// ecat_access: the one way to the controller's bytes, a byte (or a window of bits) a clock.
// A passing frame goes first, then what good frames have left to write, then the application.
// Contract, in clocks after a frame's byte_valid_i: 1 to 8 its accesses enter, one for each FMMU in use; 17 what they
// read is complete at read_data_o. The other clocks are left to the application. An access enters, is mapped (3), guarded by sync
// managers (2) and done (3). A write of some bits of a byte reads it first: after another access it enters two clocks later.
// The two sides' writes leave two clocks between an area's last byte and the next first one, as ecat_buffers needs.
module ecat_access (
    input  logic clk_i,
    input  logic rst_ni,
    output logic ready_o,   // registers have their reset values; nothing is served before
    // a frame as it passes
    input  logic        frame_start_i,
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
    output logic        app_done_o,      // of a read or write taken 8 clocks before
    output logic [7:0]  app_data_o,
    output logic        app_denied_o,    // with app_done_o
    // registers
    output ecat_pkg::register_access_t register_o,
    output logic [11:0] live_address_o,
    output logic        live_application_o,
    output logic        live_read_o,     // a read that is allowed
    input  logic        live_hit_i,      // a clock after live_address_o
    input  logic [7:0]  live_data_i,
    // sync managers
    output logic [8*ecat_pkg::SYNC_MANAGERS-1:0] status_o,
    output logic [ecat_pkg::SYNC_MANAGERS-1:0] for_application_o,
    output logic [ecat_pkg::SYNC_MANAGERS-1:0] for_master_o,
    output logic        sm_changed_o,
    output logic        watchdog_o
);

  localparam logic [3:0] MemoryEnd = 4'h3;  // 0x3000

  // Enter.
  logic running_q, logical_q, read_q, write_q, sweep_q, frame_slot, in_use, parted;
  logic [1:0] entered_q;  // in the two clocks before
  logic [1:0] ended_q;  // with the last byte of an area, of a commit
  logic [2:0] slot_q;
  logic [31:0] address_q;
  logic [7:0] data_q;
  logic [11:0] sweep_address_q;
  ecat_pkg::access_t
      entering, access_1_q, access_2_q, access_3_q, access_4_q, access_5_q, access_6_q, access_7_q, access_8_q, guarded;
  ecat_pkg::window_t
      window,
      window_1_q,
      window_2_q,
      window_3_q,
      window_4_q,
      window_5_q,
      window_6_q,
      window_7_q,
      window_8_q,
      mapped,
      fmmu_window;
  logic logical_1_q, logical_2_q, logical_3_q, fmmu_read, fmmu_write;
  logic [8:0] begin_q;  // slot 0 on its way

  assign frame_slot = running_q && (logical_q ? in_use : slot_q == '0);
  assign commit_ready_o = !frame_slot && !(commit_i.partial && entered_q != '0) && ended_q == '0;
  // Between two words of the application there is a clock anyway; parted adds the second.
  assign parted         = access_2_q.valid && access_2_q.application && !(access_1_q.valid && access_1_q.application);
  assign app_ready_o    = !frame_slot && !commit_valid_i && !sweep_q && !(app_write_i && parted);

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
      entered_q <= '0;
      ended_q   <= '0;
    end else begin
      begin_q   <= {begin_q[7:0], byte_valid_i};
      entered_q <= {entered_q[0], entering.valid};
      ended_q   <= {ended_q[0], entering.valid && entering.commit && commit_i.ends};
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

  // Map: three clocks.
  ecat_fmmus u_fmmus (
      .clk_i,
      .rst_ni,
      .register_i(register_o),
      .slot_i    (slot_q),
      .address_i (address_q),
      .in_use_o  (in_use),
      .window_o  (fmmu_window),
      .read_o    (fmmu_read),
      .write_o   (fmmu_write)
  );

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      access_1_q <= '0;
      access_2_q <= '0;
      access_3_q <= '0;
      access_4_q <= '0;
      access_5_q <= '0;
    end else begin
      access_1_q <= entering;
      access_2_q <= access_1_q;
      access_3_q <= access_2_q;
      access_4_q <= guarded;
      access_5_q <= access_4_q;
    end
  end
  always_ff @(posedge clk_i) begin
    window_1_q  <= window;
    logical_1_q <= logical_q && frame_slot;
    window_2_q  <= window_1_q;
    logical_2_q <= logical_1_q;
    window_3_q  <= window_2_q;
    logical_3_q <= logical_2_q;
    window_4_q  <= mapped;
    window_5_q  <= window_4_q;
  end

  always_comb begin
    guarded = access_3_q;
    mapped  = window_3_q;
    if (logical_3_q) begin
      mapped        = fmmu_window;
      guarded.read  = access_3_q.read && fmmu_read;
      guarded.write = access_3_q.write && fmmu_write;
    end
  end

  // Guard: three clocks.
  logic sm_read, sm_write, sm_ends, is_register, exists, may_read, may_write, could_write, refused, asked;
  logic [15:0] sm_address, address_6_q, address_7_q, address_8_q;
  ecat_sync_managers u_sync_managers (
      .clk_i,
      .rst_ni,
      .register_i(register_o),
      .status_o,
      .frame_start_i,
      .access_i  (guarded),
      .window_i  (mapped),
      .read_o    (sm_read),
      .write_o   (sm_write),
      .ends_o    (sm_ends),
      .address_o (sm_address),
      .for_application_o,
      .for_master_o,
      .changed_o (sm_changed_o),
      .watchdog_o
  );

  assign is_register = window_5_q.address[15:12] == '0;
  assign exists      = window_5_q.address[15:12] < MemoryEnd && sm_address[15:12] < MemoryEnd;
  assign may_read    = access_5_q.valid && access_5_q.read && sm_read && exists;
  assign could_write = access_5_q.valid && access_5_q.write && sm_write && exists
                       && (!is_register || (access_5_q.application
                           ? esc_regmap_pkg::application_writes(window_5_q.address[11:0])
                           : esc_regmap_pkg::master_writes(window_5_q.address[11:0])));
  assign may_write   = could_write && !refused;
  assign asked       = access_5_q.valid && (access_5_q.read || access_5_q.write);

  ecat_protection u_protection (
      .clk_i,
      .rst_ni,
      .register_i(register_o),
      .frame_start_i,
      .access_i  (access_5_q),
      .window_i  (window_5_q),
      .writes_i  (could_write),
      .refused_o (refused)
  );

  // Reads of registers that have an effect, and of the first byte of each latch's time.
  logic effective;
  assign effective = window_5_q.address == {4'd0, esc_regmap_pkg::REG_DL_STATUS}
                     || window_5_q.address == {4'd0, esc_regmap_pkg::REG_AL_STATUS}
                     || (window_5_q.address >= {4'd0, esc_regmap_pkg::REG_LATCH_TIME_0_RISING}
                         && window_5_q.address <= {4'd0, esc_regmap_pkg::REG_LATCH_TIME_1_FALLING}
                         && window_5_q.address[2:0] == '0);

  always_comb begin
    entry_o        = '0;
    entry_o.read   = may_read && (sm_ends || effective);
    entry_o.write  = may_write;
    entry_o.partial = may_write && (window_5_q.mask != '1 || window_5_q.shift != '0);
    entry_o.ends   = sm_ends;
    entry_o.data   = access_5_q.data;
    entry_o.window = window_5_q;
  end
  assign push_o = access_5_q.frame && (entry_o.read || entry_o.write);

  logic denied_6_q, denied_7_q, denied_8_q;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      access_6_q <= '0;
      access_7_q <= '0;
      denied_6_q <= 1'b0;
      denied_7_q <= 1'b0;
      denied_8_q <= 1'b0;
      access_8_q <= '0;
    end else begin
      access_6_q       <= access_5_q;
      access_6_q.read  <= may_read;
      access_6_q.write <= may_write;
      access_7_q       <= access_6_q;
      denied_6_q       <= asked && !may_read && !may_write;
      denied_7_q       <= denied_6_q;
      denied_8_q       <= denied_7_q;
      access_8_q       <= access_7_q;
    end
  end
  always_ff @(posedge clk_i) begin
    window_6_q  <= window_5_q;
    address_6_q <= sm_address;
    window_7_q  <= window_6_q;
    address_7_q <= address_6_q;
    window_8_q  <= window_7_q;
    address_8_q <= address_7_q;
  end

  // Read, change, write.
  logic [15:0] stored, held_q, held, mask, fresh, merged, wide_mask, wide_data;
  logic [7:0] first, byte_read;
  logic [1:0] store;
  logic live_7_q, live_8_q;

  assign live_address_o     = window_6_q.address[11:0];
  assign live_application_o = access_6_q.application;
  assign live_read_o        = access_6_q.valid && access_6_q.read;
  always_ff @(posedge clk_i) begin
    live_7_q <= window_6_q.address[15:12] == '0;
    live_8_q <= live_7_q;
    held_q   <= {stored[15:8], first};
  end

  ecat_memory u_memory (
      .clk_i,
      .read_address_i (address_6_q[13:0]),
      .read_data_o    (stored),
      .write_i        (sweep_q ? 2'b01 : store),
      .write_address_i(sweep_q ? {2'd0, sweep_address_q} : address_8_q[13:0]),
      .write_data_i   (sweep_q ? {8'd0, esc_regmap_pkg::reset_byte(sweep_address_q)} : merged)
  );

  assign first     = live_7_q && live_hit_i ? live_data_i : stored[7:0];
  assign held      = window_8_q.high ? {held_q[7:0], 8'd0} : held_q;
  assign byte_read = 8'(held >> window_8_q.shift) & window_8_q.mask;
  assign wide_mask = {8'd0, window_8_q.mask} << window_8_q.shift;
  assign wide_data = {8'd0, access_8_q.data} << window_8_q.shift;
  assign mask      = window_8_q.high ? {8'd0, wide_mask[15:8]} : wide_mask;
  assign fresh     = window_8_q.high ? {8'd0, wide_data[15:8]} : wide_data;
  assign merged    = (held_q & ~mask) | (fresh & mask);
  assign store     = {2{access_8_q.valid && access_8_q.write && !access_8_q.frame}}
                     & {mask[15:8] != '0, mask[7:0] != '0};

  ecat_pkg::register_access_t register_q;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      register_q <= '0;
    end else begin
      register_q.write       <= store[0] && live_8_q;
      register_q.read        <= access_8_q.valid && access_8_q.read && !access_8_q.frame && live_8_q;
      register_q.application <= access_8_q.application;
      register_q.address     <= window_8_q.address[11:0];
      register_q.data        <= merged[7:0];
    end
  end
  assign register_o = register_q;

  // What a frame's byte read, over all FMMUs.
  logic [7:0] read_data_q, read_mask_q;
  logic read_done_q, write_done_q, seen;
  assign seen = access_8_q.valid && access_8_q.frame;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      read_data_q  <= '0;
      read_mask_q  <= '0;
      read_done_q  <= 1'b0;
      write_done_q <= 1'b0;
    end else begin
      read_data_q  <= (begin_q[8] ? '0 : read_data_q) | (seen && access_8_q.read ? byte_read : '0);
      read_mask_q  <= (begin_q[8] ? '0 : read_mask_q) | (seen && access_8_q.read ? window_8_q.mask : '0);
      read_done_q  <= (!begin_q[8] && read_done_q) || (seen && access_8_q.read);
      write_done_q <= (!begin_q[8] && write_done_q) || (seen && access_8_q.write);
    end
  end
  assign read_data_o  = read_data_q;
  assign read_mask_o  = read_mask_q;
  assign read_done_o  = read_done_q;
  assign write_done_o = write_done_q;

  assign app_done_o   = access_8_q.valid && access_8_q.application;
  assign app_data_o   = access_8_q.read ? byte_read : '0;
  assign app_denied_o = denied_8_q;

  logic unused;
  assign unused = &{access_8_q.commit, address_8_q[15:14]};

  // After reset every register's byte gets its value.
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
