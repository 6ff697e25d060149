// SPDX-License-Identifier: Apache-2.0
// debug_serve: carries requests out on the bus, and makes the packets that go back (docs/debug_block.md).
// Contract: requests go first, then events, then samples; each packet is built from begin to end. Samples
// are read from the ring in clocks without ring_taken_i; their records are sent in order, and the oldest
// are left out, and counted, when the ring is about to overwrite them. Where the scope is armed while a packet
// of samples is made, the next one begins with record 0.
module debug_serve #(
    parameter int unsigned RingLog2 = 12
) (
    input  logic                clk_i,
    input  logic                rst_ni,
    // from the registers
    input  logic                stream_i,
    input  logic                events_i,
    input  logic [31:0]         status_i,
    input  logic [31:0]         place_i,
    input  logic [31:0]         runs_i,
    input  logic [31:0]         records_i,
    input  logic [2:0]          last_channel_i,
    input  logic [1:0]          size_log2_i,
    input  logic                armed_i,
    output logic [15:0]         lost_o,
    // request
    input  logic                request_i,
    input  logic [5:0]          length_i,
    output logic [5:0]          index_o,
    input  logic [7:0]          byte_i,
    output logic                done_o,
    // packet
    input  logic                ready_i,
    output logic                put_o,
    output logic [7:0]          data_o,
    output logic                end_o,
    // bus
    output logic                read_o,
    output logic                write_o,
    output logic [14:0]         address_o,
    output logic [31:0]         writedata_o,
    input  logic [31:0]         readdata_i,
    input  logic                wait_i,
    // ring
    input  logic                ring_taken_i,
    output logic [RingLog2-1:0] ring_address_o,
    input  logic [31:0]         ring_data_i
);

  typedef enum logic [4:0] {
    StIdle,
    // of the request
    StType,
    StSequence,
    StLow,
    StHigh,
    StCount,
    StHead,  // type and sequence number of the answer
    // words of a request
    StRead,
    StReadHere,
    StGather,
    StWrite,
    StPut,  // bytes of word_q, then state after_q
    StEventPlace,
    StEventRuns,
    // head of samples
    StNumber,
    StChannels,
    // two words of the ring
    StNow,
    StNowHere,
    StBefore,
    StBeforeHere,
    StDifference,
    // codes of a record, end of a record
    StCode,
    StRecord,
    StEnd
  } state_e;

  // What changes of STATUS make an event.
  localparam logic [31:0] Told = 32'(
      (1 << debug_regmap_pkg::STATUS_HELD_LSB) | (1 << debug_regmap_pkg::STATUS_HALTED_LSB) |
      (1 << debug_regmap_pkg::STATUS_FAULT_LSB) | (3 << debug_regmap_pkg::STATUS_SCOPE_LSB));
  localparam int unsigned Margin = 16;  // records
  localparam int unsigned Fullest = 252 - 2 - 32;  // bytes of a packet that takes a record more

  state_e state_q, after_q;
  logic [7:0] type_q, sequence_q, last_sequence_q, own_sequence_q, used_q;
  logic answered_q, repeated_q, values_q, first_q, again_q;
  logic [15:0] address_q;
  logic [5:0] index_q, left_q;  // left: words of a READ
  logic [31:0] word_q, told_q, tail_q, now_q, difference;
  logic [2:0] bytes_q, channel_q;
  logic [1:0] byte_q, code;
  logic [15:0] codes_q, lost_q;
  logic [31:0] backlog;
  logic [12:0] most;
  logic is_read, is_write, good, behind, change, last_channel, moves;
  logic behind_q, some_q, more_q, judged_q;  // of the backlog; checked: of this tail
  logic restart_q;  // records count from 0 again, samples after this packet too
  logic [31:0] from;

  assign is_read  = type_q == debug_pkg::TYPE_READ;
  assign is_write = type_q == debug_pkg::TYPE_WRITE;
  assign good     = is_read ? length_i == 6'd7 && |byte_i && byte_i <= 8'(debug_pkg::READ_WORDS)
                            : length_i[1:0] == 2'd2 && length_i >= 6'd10;

  assign backlog  = records_i - tail_q;
  assign most     = (13'd1 << RingLog2) >> size_log2_i;
  assign behind   = (|backlog[31:13]) || backlog[12:0] > most - 13'(Margin);
  // The backlog is checked a clock after the tail has moved.
  assign moves    = armed_i || restart_q || state_q == StRecord ||
                    (state_q == StIdle && (!stream_i || (judged_q && behind_q)));
  assign change   = |((status_i ^ told_q) & Told);
  assign last_channel = channel_q == last_channel_i;

  // The byte of the next clock.
  always_comb begin
    case (state_q)
      StIdle: index_o = '0;
      StType, StSequence, StLow, StHigh, StGather: index_o = index_q + 6'd1;
      default: index_o = index_q;
    endcase
  end

  // Word of a channel in the record `tail_q`, or the one before.
  assign from           = tail_q - 32'(state_q == StBefore);
  assign ring_address_o = RingLog2'(from << size_log2_i) | RingLog2'(channel_q);
  assign difference     = now_q ^ word_q;
  assign code           = (|difference[31:24]) ? 2'd3 : (|difference[23:16]) ? 2'd2 :
                          (|difference[15:0]) ? 2'd1 : 2'd0;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q         <= StIdle;
      after_q         <= StIdle;
      type_q          <= '0;
      sequence_q      <= '0;
      last_sequence_q <= '0;
      own_sequence_q  <= '0;
      used_q          <= '0;
      answered_q      <= 1'b0;
      repeated_q      <= 1'b0;
      values_q        <= 1'b0;
      first_q         <= 1'b0;
      again_q         <= 1'b0;
      address_q       <= '0;
      index_q         <= '0;
      left_q          <= '0;
      word_q          <= '0;
      told_q          <= '0;
      tail_q          <= '0;
      now_q           <= '0;
      bytes_q         <= '0;
      channel_q       <= '0;
      byte_q          <= '0;
      codes_q         <= '0;
      lost_q          <= '0;
      behind_q        <= 1'b0;
      some_q          <= 1'b0;
      more_q          <= 1'b0;
      judged_q        <= 1'b0;
      restart_q       <= 1'b0;
    end else begin
      behind_q  <= behind;
      some_q    <= |backlog;
      more_q    <= backlog > 32'd1;
      judged_q  <= !moves;
      restart_q <= armed_i || (restart_q && state_q != StIdle);
      if (put_o) used_q <= used_q + 8'd1;
      index_q <= index_o;
      case (state_q)
        StIdle: begin
          used_q <= '0;
          if (!stream_i) tail_q <= records_i;
          if (ready_i) begin
            if (request_i) begin
              state_q <= StType;
            end else if (events_i && change) begin
              type_q     <= debug_pkg::TYPE_EVENT;
              sequence_q <= own_sequence_q;
              told_q     <= status_i;
              state_q    <= StHead;
            end else if (stream_i && judged_q && behind_q) begin
              tail_q <= tail_q + 32'd1;
              lost_q <= lost_q + 16'd1;
            end else if (stream_i && judged_q && some_q) begin
              type_q     <= debug_pkg::TYPE_SAMPLES;
              sequence_q <= own_sequence_q;
              again_q    <= 1'b0;
              state_q    <= StHead;
            end
          end
        end

        // ---- request: bytes come one a clock
        StType: begin
          type_q  <= byte_i;
          state_q <= StSequence;
        end
        StSequence: begin
          sequence_q      <= byte_i;
          repeated_q      <= answered_q && byte_i == last_sequence_q;
          last_sequence_q <= byte_i;
          answered_q      <= 1'b1;
          state_q         <= StLow;
        end
        StLow: begin
          address_q[7:0] <= byte_i;
          state_q        <= StHigh;
        end
        StHigh: begin
          address_q[15:8] <= byte_i;
          state_q         <= StCount;
        end
        StCount: begin
          left_q  <= byte_i[5:0];
          byte_q  <= '0;
          state_q <= StHead;
          if (!(is_read || is_write)) begin
            type_q <= debug_pkg::TYPE_ERROR;
            word_q <= 32'(debug_pkg::ERROR_TYPE);
          end else if (!good) begin
            type_q <= debug_pkg::TYPE_ERROR;
            word_q <= 32'(debug_pkg::ERROR_LENGTH);
          end
        end

        // ---- head of a packet: its type, then (again_q) its sequence number
        StHead: begin
          again_q <= !again_q;
          if (again_q) begin
            case (type_q)
              debug_pkg::TYPE_READ: state_q <= StRead;
              debug_pkg::TYPE_WRITE: state_q <= StGather;
              debug_pkg::TYPE_ERROR: begin
                bytes_q <= 3'd1;
                after_q <= StEnd;
                state_q <= StPut;
              end
              default: begin
                own_sequence_q <= own_sequence_q + 8'd1;
                word_q         <= type_q == debug_pkg::TYPE_EVENT ? told_q : tail_q;
                bytes_q        <= 3'd4;
                after_q        <= type_q == debug_pkg::TYPE_EVENT ? StEventPlace : StChannels;
                state_q        <= StPut;
              end
            endcase
          end
        end

        // ---- words of a request
        StRead: begin
          now_q <= readdata_i;  // memories answer late in a clock
          if (!wait_i) state_q <= StReadHere;
        end
        StReadHere: begin
          word_q    <= now_q;
          address_q <= address_q + 16'd1;
          left_q    <= left_q - 6'd1;
          bytes_q   <= 3'd4;
          after_q   <= left_q == 6'd1 ? StEnd : StRead;
          state_q   <= StPut;
        end
        StGather: begin
          word_q  <= {byte_i, word_q[31:8]};
          byte_q  <= byte_q + 2'd1;
          if (byte_q == 2'd3) state_q <= StWrite;
        end
        StWrite: begin
          if (!wait_i || repeated_q) begin
            address_q <= address_q + 16'd1;
            state_q   <= index_q + 6'd2 == length_i ? StEnd : StGather;
          end
        end

        StPut: begin
          word_q  <= word_q >> 8;
          bytes_q <= bytes_q - 3'd1;
          if (bytes_q == 3'd1) state_q <= after_q;
        end

        // ---- event
        StEventPlace: begin
          word_q  <= place_i;
          bytes_q <= 3'd4;
          after_q <= StEventRuns;
          state_q <= StPut;
        end
        StEventRuns: begin
          word_q  <= runs_i;
          bytes_q <= 3'd4;
          after_q <= StEnd;
          state_q <= StPut;
        end

        // ---- samples: for each record the codes (values_q low), then the bytes
        StChannels: begin
          word_q    <= 32'(last_channel_i) + 32'd1;
          bytes_q   <= 3'd1;
          after_q   <= StNow;
          first_q   <= 1'b1;
          values_q  <= 1'b0;
          channel_q <= '0;
          state_q   <= StPut;
        end
        StNow: if (!ring_taken_i) state_q <= StNowHere;
        StNowHere: begin
          now_q   <= ring_data_i;
          state_q <= StBefore;
        end
        StBefore: if (!ring_taken_i) state_q <= StBeforeHere;
        StBeforeHere: begin
          word_q  <= first_q ? 32'd0 : ring_data_i;
          state_q <= StDifference;
        end
        StDifference: begin
          word_q    <= difference;
          bytes_q   <= {1'b0, code} + 3'd1;
          channel_q <= last_channel ? 3'd0 : channel_q + 3'd1;
          if (!values_q) begin
            codes_q[{channel_q, 1'b0}+:2] <= code;
            state_q <= last_channel ? StCode : StNow;
          end else begin
            after_q <= last_channel ? StRecord : StNow;
            state_q <= |code ? StPut : last_channel ? StRecord : StNow;
          end
        end
        StCode: begin
          word_q   <= 32'(codes_q);
          bytes_q  <= last_channel_i[2] ? 3'd2 : 3'd1;
          values_q <= 1'b1;
          after_q  <= StNow;
          state_q  <= StPut;
        end
        StRecord: begin
          tail_q   <= tail_q + 32'd1;
          first_q  <= 1'b0;
          values_q <= 1'b0;
          codes_q  <= '0;
          state_q  <= more_q && used_q <= 8'(Fullest) && !behind_q ? StNow : StEnd;
        end

        default: state_q <= StIdle;  // StEnd
      endcase
      if (state_q == StIdle && restart_q) tail_q <= '0;
    end
  end

  always_comb begin
    put_o  = state_q == StHead || state_q == StPut;
    data_o = word_q[7:0];
    if (state_q == StHead) begin
      data_o = again_q ? sequence_q : type_q;
      if (!again_q && (is_read || is_write)) data_o = type_q | 8'h80;
    end
  end

  assign end_o       = state_q == StEnd;
  assign done_o      = state_q == StEnd && request_i && type_q != debug_pkg::TYPE_EVENT &&
                       type_q != debug_pkg::TYPE_SAMPLES;
  assign read_o      = state_q == StRead;
  assign write_o     = state_q == StWrite && !repeated_q;
  assign address_o   = address_q[14:0];
  assign writedata_o = word_q;
  assign lost_o      = lost_q;

endmodule
