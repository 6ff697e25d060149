// SPDX-License-Identifier: Apache-2.0
// ecat_sync_managers: finds the sync manager that guards a byte, whether the access is allowed, and where in the memory
// its buffer lies; keeps buffers, mailboxes and events of all of them.
// Contract: the answer follows the access by two clocks. What an access to a first or last byte brings about happens
// a clock before: a frame's access opens its buffer as it passes, everything else waits for the commit. An area is open for a side
// from its access to the first byte to that of the last one; other accesses are refused.
module ecat_sync_managers (
    input  logic clk_i,
    input  logic rst_ni,
    // registers
    input  ecat_pkg::register_access_t register_i,
    output logic [8*ecat_pkg::SYNC_MANAGERS-1:0] status_o,
    // an access
    input  logic        frame_start_i,
    input  ecat_pkg::access_t access_i,
    input  ecat_pkg::window_t window_i,
    output logic        read_o,     // allowed
    output logic        write_o,
    output logic        ends_o,     // it is a last byte
    output logic [15:0] address_o,  // in the memory
    // events, a bit a sync manager
    output logic [ecat_pkg::SYNC_MANAGERS-1:0] for_application_o,
    output logic [ecat_pkg::SYNC_MANAGERS-1:0] for_master_o,
    output logic        changed_o,        // the master has set one up
    output logic        watchdog_o        // its write restarts the watchdog
);

  localparam int unsigned N = ecat_pkg::SYNC_MANAGERS;
  localparam logic [2:0] Start = 3'(esc_regmap_pkg::REG_SM_START);
  localparam logic [2:0] Length = 3'(esc_regmap_pkg::REG_SM_LENGTH);
  localparam logic [2:0] Control = 3'(esc_regmap_pkg::REG_SM_CONTROL);
  localparam logic [2:0] Activate = 3'(esc_regmap_pkg::REG_SM_ACTIVATE);
  localparam logic [2:0] Side = 3'(esc_regmap_pkg::REG_SM_PDI);

  logic here, crosses;
  logic [7:0] high_part;
  logic [N-1:0] hit_q, begin_q, end_q, boxes, master_writes, full, enabled, triggers;
  logic [N-1:0] read_allowed, write_allowed, begun, written;
  logic [2*N-1:0] writer, reader;
  logic [16*N-1:0] lengths;
  ecat_pkg::access_t access_q;
  logic [15:0] address_q;

  assign here = register_i.write && register_i.address[11:6] == esc_regmap_pkg::REG_SM_START[11:6];
  assign high_part = 8'(({8'd0, window_i.mask} << window_i.shift) >> 8);
  assign crosses = !window_i.high && high_part != '0;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) access_q <= '0;
    else access_q <= access_i;
  end
  always_ff @(posedge clk_i) address_q <= window_i.address;

  genvar index;
  generate
    for (index = 0; index < N; index++) begin : gen_manager
      logic [15:0] start_q, length_q, distance, past;
      logic before_end;
      logic [7:0] control_q, status;
      logic [1:0] last;
      logic enable_q, disable_q, mine, is_written, is_read, reads, writes, pdi_event, master_event;

      assign mine = here && register_i.address[5:3] == 3'(index);
      always_ff @(posedge clk_i or negedge rst_ni) begin
        if (!rst_ni) begin
          start_q    <= '0;
          length_q   <= '0;
          control_q  <= '0;
          enable_q   <= 1'b0;
          disable_q  <= 1'b0;
        end else if (mine) begin
          case (register_i.address[2:0])
            Start: start_q[7:0] <= register_i.data;
            Start + 3'd1: start_q[15:8] <= register_i.data;
            Length: length_q[7:0] <= register_i.data;
            Length + 3'd1: length_q[15:8] <= register_i.data;
            Control: control_q <= register_i.data;
            Activate: enable_q <= register_i.data[esc_regmap_pkg::SM_ACTIVATE_ENABLE_LSB];
            Side: disable_q <= register_i.data[esc_regmap_pkg::SM_PDI_DISABLE_LSB];
            default: ;
          endcase
        end
      end

      assign enabled[index]       = enable_q && !disable_q;
      assign boxes[index]         = control_q[esc_regmap_pkg::SM_CONTROL_MODE_LSB+1];  // its upper bit decides
      assign master_writes[index] = control_q[esc_regmap_pkg::SM_CONTROL_DIRECTION_LSB];
      assign master_event         = control_q[esc_regmap_pkg::SM_CONTROL_MASTER_EVENT_LSB];
      assign pdi_event            = control_q[esc_regmap_pkg::SM_CONTROL_PDI_EVENT_LSB];
      assign triggers[index]      = control_q[esc_regmap_pkg::SM_CONTROL_WATCHDOG_LSB];
      assign lengths[16*index+:16] = length_q;

      // First clock: whether the byte is guarded. One difference decides whether it lies inside, and at the end.
      assign distance = window_i.address - start_q;
      assign {before_end, past} = {1'b0, distance} - {1'b0, length_q};
      always_ff @(posedge clk_i or negedge rst_ni) begin
        if (!rst_ni) begin
          hit_q[index]   <= 1'b0;
          begin_q[index] <= 1'b0;
          end_q[index]   <= 1'b0;
        end else begin
          hit_q[index]   <= enabled[index] && before_end;
          begin_q[index] <= distance == '0;
          end_q[index]   <= past[15:1] == '1 && (past[0] || crosses);
        end
      end

      // Second: whether this side may, and what follows.
      assign reads = (access_q.application == master_writes[index]) &&
                     (access_q.commit || !boxes[index] || full[index]);
      assign writes = (access_q.application != master_writes[index]) &&
                      (access_q.commit || !boxes[index] || !full[index]);
      assign read_allowed[index]  = reads && begun[index];
      assign write_allowed[index] = writes && begun[index];

      ecat_buffers u_buffers (
          .clk_i,
          .rst_ni,
          .clear_i  (!enabled[index]),
          .mailbox_i(boxes[index]),
          .frame_start_i,
          .passing_i(access_q.frame),
          .commit_i (access_q.commit),
          .reads_i  (access_q.valid && access_q.read && hit_q[index] && reads),
          .writes_i (access_q.valid && access_q.write && hit_q[index] && writes),
          .first_i  (begin_q[index]),
          .ends_i   (end_q[index]),
          .begun_o  (begun[index]),
          .is_written_o(written[index]),
          .writer_o (writer[2*index+:2]),
          .reader_o (reader[2*index+:2]),
          .last_o   (last),
          .full_o   (full[index]),
          .written_o(is_written),
          .read_o   (is_read)
      );

      always_comb begin
        status = '0;
        status[esc_regmap_pkg::SM_STATUS_WRITTEN_LSB] = is_written;
        status[esc_regmap_pkg::SM_STATUS_READ_LSB]    = is_read;
        status[esc_regmap_pkg::SM_STATUS_FULL_LSB]    = full[index];
        status[esc_regmap_pkg::SM_STATUS_NEWEST_LSB+:esc_regmap_pkg::SM_STATUS_NEWEST_WIDTH] = last;
      end
      assign status_o[8*index+:8] = status;
      assign for_application_o[index] = pdi_event && (master_writes[index] ? is_written : is_read);
      assign for_master_o[index]      = master_event && (master_writes[index] ? is_read : is_written);

      logic unused_bits;
      assign unused_bits = &control_q;
    end
  endgenerate

  // The guarding one, the lowest of those that overlap; where its buffer lies.
  logic [1:0] buffer, buffer_q;
  logic [15:0] length, span_q, address_late_q;
  logic guarded, allow_read, allow_write, is_end;
  always_comb begin
    buffer  = 2'd0;
    length  = '0;
    guarded = 1'b0;
    allow_read  = 1'b1;
    allow_write = 1'b1;
    is_end      = 1'b0;
    for (int n = N - 1; n >= 0; n--) begin
      if (hit_q[n]) begin
        guarded = 1'b1;
        buffer  = (access_q.application == master_writes[n]) ? reader[2*n+:2] : writer[2*n+:2];
        length  = lengths[16*n+:16];
        allow_read  = read_allowed[n];
        allow_write = write_allowed[n];
        is_end      = end_q[n];
      end
    end
    if (access_q.commit) begin
      allow_read  = 1'b1;
      allow_write = 1'b1;
    end
  end
  always_ff @(posedge clk_i) begin
    buffer_q       <= guarded ? buffer : 2'd0;
    span_q         <= length;
    address_late_q <= address_q;
    read_o         <= allow_read;
    write_o        <= allow_write;
    ends_o         <= is_end;
  end
  assign address_o = address_late_q + (buffer_q[0] ? span_q : 16'd0)
                     + (buffer_q[1] ? {span_q[14:0], 1'b0} : 16'd0);

  assign watchdog_o = |(written & triggers & {N{access_q.commit}});
  assign changed_o  = here && !register_i.application
                      && (register_i.address[2:0] == Activate || register_i.address[2:0] == Control);

  logic unused;
  assign unused = &{register_i.read, access_q.data, window_i.high};

endmodule
