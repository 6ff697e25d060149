// SPDX-License-Identifier: Apache-2.0
// ecat_datagrams: walks through a frame's bytes and says what each becomes.
// Contract: result_o is byte_i's answer from 18 clocks after byte_valid_i on, for 8 clocks. A byte of data that this
// slave serves is a request_o for 8 clocks of accesses, slot 0 with it; what they read comes back as
// read_data_i under read_mask_i 17 clocks after byte_valid_i, read_done_i and write_done_i with it. Datagrams
// are served if serve_i holds when their data begin. malformed_o with frame_end_i: a datagram does not
// end within its frame; frames of another type are never malformed. Bytes after the last datagram stay.
// Every frame leaves with its source marked as locally administered (bit 1 of the first byte): by it a master
// distinguishes an answer from its own frame.
// Datagrams may also come in UDP: IPv4 without options, not in fragments, to port 88A4. The check sum of UDP leaves
// as 0, which means none, because the answer changes bytes after it.
module ecat_datagrams (
    input  logic clk_i,
    input  logic rst_ni,
    // stream
    input  logic       frame_start_i,
    input  logic       byte_valid_i,
    input  logic [7:0] byte_i,
    output logic [7:0] result_o,
    output logic       malformed_o,
    output logic       foreign_o,      // the frame is of another type
    // slave
    input  logic        serve_i,
    input  logic [15:0] station_i,
    input  logic [15:0] alias_i,
    input  logic        alias_on_i,
    input  logic [15:0] event_i,       // is or-ed to the interrupt field
    input  logic        looped_i,      // frames come from port 1, port 0 is closed
    input  logic        cut_foreign_i, // frames of another type are destroyed
    output logic        destroy_o,     // the frame circulates, or is of another type
    // accesses
    output logic        request_o,
    output logic        logical_o,
    output logic [31:0] address_o,
    output logic        read_o,
    output logic        write_o,
    output logic [7:0]  data_o,
    input  logic [7:0]  read_data_i,
    input  logic [7:0]  read_mask_i,
    input  logic        read_done_i,
    input  logic        write_done_i
);

  typedef enum logic [3:0] {
    StSource   = 4'd0,  // addresses of Ethernet
    StType     = 4'd1,
    StTag      = 4'd2,  // the other half of an 802.1Q tag
    StHeader   = 4'd3,  // of the frame: length, type
    StDatagram = 4'd4,  // its header
    StData     = 4'd5,
    StCounter  = 4'd6,  // working counter
    StRest     = 4'd7,
    StForeign  = 4'd8,
    StBroken   = 4'd9,  // a datagram reaches beyond the frame
    StUdp      = 4'd10  // headers of IPv4 and UDP
  } state_e;

  localparam logic [15:0] EtherType = 16'h88A4;
  localparam logic [15:0] TagType = 16'h8100;
  localparam logic [15:0] IpType = 16'h0800;
  localparam logic [15:0] UdpPort = 16'h88A4;
  // Bytes of the headers of IPv4 (RFC 791) and UDP (RFC 768).
  localparam logic [4:0] IpVersion = 5'd0;  // and length of the header
  localparam logic [4:0] IpFragmentHigh = 5'd6;
  localparam logic [4:0] IpFragmentLow = 5'd7;
  localparam logic [4:0] IpProtocol = 5'd9;
  localparam logic [4:0] UdpPortLow = 5'd23;
  localparam logic [4:0] UdpSumHigh = 5'd26;
  localparam logic [4:0] UdpSumLow = 5'd27;
  localparam logic [7:0] PlainIpV4 = 8'h45;
  localparam logic [7:0] ProtocolUdp = 8'h11;
  localparam logic [3:0] FrameType = 4'd1;  // a frame of datagrams
  localparam int unsigned SequenceBytes = 4;
  localparam logic [3:0] SourceByte = 4'd6;  // follows the destination
  localparam logic [7:0] LocalSource = 8'h02;

  // What an answer is made of; taken up to 8 clocks after its byte, used at 17.
  localparam logic [2:0] PartByte = 3'd0;  // the byte given here
  localparam logic [2:0] PartClear = 3'd1;  // the same, and the working counter's sums begin again
  localparam logic [2:0] PartReplace = 3'd2;
  localparam logic [2:0] PartOr = 3'd3;
  localparam logic [2:0] PartCountLow = 3'd4;
  localparam logic [2:0] PartCountHigh = 3'd5;

  state_e state_q;
  logic [3:0] count_q;
  logic [4:0] udp_q;  // number of the byte in StUdp
  logic foreign_udp;
  logic [2:0] rest_q;  // bytes after the last datagram, up to SequenceBytes
  logic [7:0] high_q, command_q;
  logic [31:0] address_q;
  logic [10:0] left_q, length_q;
  logic carry_q, more_q, zero_q, begun_q, served_q;
  logic positioned, addressed, broadcast, logical, any_read, any_write, both, read, write;
  logic [15:0] offset;
  logic [7:0] answer;
  logic [2:0] part, part_q, part_late_q, part_last_q;
  logic [7:0] answer_q, answer_late_q, answer_last_q;
  logic [16:0] strobe_q;
  logic read_seen_q, write_seen_q, counter_carry_q, both_q, both_last_q;
  logic [8:0] counted;
  logic [1:0] increment;

  // Commands.
  always_comb begin
    positioned = 1'b0;
    broadcast  = 1'b0;
    logical    = 1'b0;
    any_read   = 1'b0;
    any_write  = 1'b0;
    case (command_q)
      ecat_pkg::CMD_APRD: {positioned, any_read} = 2'b11;
      ecat_pkg::CMD_APWR: {positioned, any_write} = 2'b11;
      ecat_pkg::CMD_APRW: {positioned, any_read, any_write} = 3'b111;
      ecat_pkg::CMD_FPRD: any_read = 1'b1;
      ecat_pkg::CMD_FPWR: any_write = 1'b1;
      ecat_pkg::CMD_FPRW: {any_read, any_write} = 2'b11;
      ecat_pkg::CMD_BRD: {broadcast, any_read} = 2'b11;
      ecat_pkg::CMD_BWR: {broadcast, any_write} = 2'b11;
      ecat_pkg::CMD_BRW: {broadcast, any_read, any_write} = 3'b111;
      ecat_pkg::CMD_LRD: {logical, any_read} = 2'b11;
      ecat_pkg::CMD_LWR: {logical, any_write} = 2'b11;
      ecat_pkg::CMD_LRW: {logical, any_read, any_write} = 3'b111;
      ecat_pkg::CMD_ARMW: {positioned, any_read, any_write} = 3'b111;
      ecat_pkg::CMD_FRMW: {any_read, any_write} = 2'b11;
      default: ;
    endcase
  end

  // Whom the datagram means: zero_q, the position was 0 as it came in; address_q[15:0] is as it came in.
  assign addressed = logical || broadcast || (positioned ? zero_q
                     : address_q[15:0] == station_i || (alias_on_i && address_q[15:0] == alias_i));
  always_comb begin
    read  = any_read && addressed;
    write = any_write && addressed;
    both  = any_read && any_write;
    if (command_q == ecat_pkg::CMD_ARMW || command_q == ecat_pkg::CMD_FRMW) begin
      write = !addressed;
      both  = 1'b0;
    end
  end

  assign offset = address_q[31:16];

  // The answer as far as it is known with the byte.
  always_comb begin
    answer = byte_i;
    part   = PartByte;
    case (state_q)
      StSource: if (count_q == SourceByte) answer = byte_i | LocalSource;
      StUdp: if (udp_q == UdpSumHigh || udp_q == UdpSumLow) answer = '0;
      StDatagram: begin
        case (count_q)
          4'd0: part = PartClear;
          4'd2: if (positioned || broadcast) answer = byte_i + 8'd1;
          4'd3: if (positioned || broadcast) answer = byte_i + {7'd0, carry_q};
          4'd7: if (looped_i && !begun_q) answer = byte_i | 8'h40;
          4'd8: answer = byte_i | event_i[7:0];
          4'd9: answer = byte_i | event_i[15:8];
          default: ;
        endcase
      end
      StData: begin
        if (served_q && read) part = broadcast ? PartOr : PartReplace;
      end
      StCounter: part = count_q[0] ? PartCountHigh : PartCountLow;
      default: ;
    endcase
  end

  // A header of IPv4 or UDP that brings no datagrams.
  always_comb begin
    case (udp_q)
      IpVersion: foreign_udp = byte_i != PlainIpV4;
      IpFragmentHigh: foreign_udp = byte_i[5:0] != '0;
      IpFragmentLow: foreign_udp = byte_i != '0;
      IpProtocol: foreign_udp = byte_i != ProtocolUdp;
      UdpPortLow: foreign_udp = {high_q, byte_i} != UdpPort;
      default: foreign_udp = 1'b0;
    endcase
  end

  assign destroy_o = byte_valid_i
                     && ((state_q == StDatagram && count_q == 4'd7 && looped_i && !begun_q && byte_i[6])
                         || (state_q == StForeign && cut_foreign_i));

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q   <= StForeign;
      count_q   <= '0;
      udp_q     <= '0;
      rest_q    <= '0;
      command_q <= '0;
      address_q <= '0;
      left_q    <= '0;
      length_q  <= '0;
      high_q    <= '0;
      carry_q   <= 1'b0;
      more_q    <= 1'b0;
      zero_q    <= 1'b0;
      begun_q   <= 1'b0;
      served_q  <= 1'b0;
    end else if (frame_start_i) begin
      state_q  <= StSource;
      count_q  <= '0;
      rest_q   <= '0;
      begun_q  <= 1'b0;
      served_q <= 1'b0;
    end else if (byte_valid_i) begin
      count_q <= count_q + 1'b1;
      high_q  <= byte_i;
      case (state_q)
        StSource:
        if (count_q == 4'd11) begin
          state_q <= StType;
          count_q <= '0;
        end
        StType:
        if (count_q[0]) begin
          count_q <= '0;
          udp_q   <= '0;
          case ({
            high_q, byte_i
          })
            EtherType: state_q <= StHeader;
            TagType: state_q <= StTag;
            IpType: state_q <= StUdp;
            default: state_q <= StForeign;
          endcase
        end
        StUdp: begin
          udp_q <= udp_q + 1'b1;
          if (foreign_udp) state_q <= StForeign;
          if (udp_q == UdpSumLow) begin
            count_q <= '0;
            state_q <= StHeader;
          end
        end
        StTag:
        if (count_q[0]) begin
          count_q <= '0;
          state_q <= StType;
        end
        StHeader:
        if (count_q[0]) begin
          count_q  <= '0;
          left_q   <= {byte_i[2:0], high_q};
          state_q  <= byte_i[7:4] != FrameType ? StForeign : {byte_i[2:0], high_q} == '0 ? StRest : StDatagram;
        end
        StDatagram: begin
          case (count_q)
            4'd0: command_q <= byte_i;
            4'd2: begin
              address_q[7:0] <= byte_i;
              carry_q        <= byte_i == 8'hFF;
            end
            4'd3: begin
              address_q[15:8] <= byte_i;
              zero_q          <= byte_i == '0 && high_q == '0;
            end
            4'd4: address_q[23:16] <= byte_i;
            4'd5: address_q[31:24] <= byte_i;
            4'd7: begin
              length_q <= {byte_i[2:0], high_q};  // then 3 bits, circulating, more
              more_q   <= byte_i[7];
            end
            4'd9: begin
              begun_q  <= 1'b1;
              served_q <= serve_i && (read || write);
              count_q  <= '0;
              state_q  <= length_q == '0 ? StCounter : StData;
            end
            default: ;
          endcase
        end
        StData: begin
          length_q  <= length_q - 1'b1;
          count_q   <= '0;
          address_q <= logical ? address_q + 1'b1 : {offset + 1'b1, address_q[15:0]};
          if (length_q == 11'd1) state_q <= StCounter;
        end
        StCounter:
        if (count_q[0]) begin
          count_q <= '0;
          state_q <= more_q ? StDatagram : StRest;
        end
        StRest: if (rest_q != 3'(SequenceBytes)) rest_q <= rest_q + 1'b1;
        default: ;
      endcase
      // The frame's length holds all of its datagrams.
      if (state_q == StDatagram || state_q == StData || state_q == StCounter) begin
        left_q <= left_q - 1'b1;
        if (left_q == 11'd1 && !(state_q == StCounter && count_q[0] && !more_q)) state_q <= StBroken;
      end
    end
  end

  assign foreign_o   = state_q == StForeign || state_q == StUdp;
  assign malformed_o = !foreign_o && (state_q != StRest || rest_q != 3'(SequenceBytes));

  // Accesses of a byte of data.
  assign request_o = byte_valid_i && state_q == StData && served_q;
  assign logical_o = logical;
  assign address_o = logical ? address_q : {16'd0, offset};
  assign read_o    = read;
  assign write_o   = write;
  assign data_o    = byte_i;

  // The answer, when what was read has come.
  always_comb begin
    increment = 2'd0;
    if (read_seen_q) increment = 2'd1;
    if (write_seen_q) increment = both_last_q ? increment + 2'd2 : increment + 2'd1;
  end
  assign counted = {1'b0, answer_last_q} + 9'(increment);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      strobe_q        <= '0;
      read_seen_q     <= 1'b0;
      write_seen_q    <= 1'b0;
      counter_carry_q <= 1'b0;
    end else begin
      strobe_q <= {strobe_q[15:0], byte_valid_i};
      if (strobe_q[16]) begin
        counter_carry_q <= part_last_q == PartCountLow && counted[8];
        if (part_last_q == PartClear) begin
          read_seen_q  <= 1'b0;
          write_seen_q <= 1'b0;
        end
        // Data alone are served, and between two of them nothing else is.
        if (read_done_i) read_seen_q <= 1'b1;
        if (write_done_i) write_seen_q <= 1'b1;
      end
    end
  end

  always_ff @(posedge clk_i) begin
    if (byte_valid_i) begin
      answer_q <= answer;
      part_q   <= part;
    end
    if (strobe_q[7]) begin
      answer_late_q <= answer_q;
      part_late_q   <= part_q;
      both_q        <= both;
    end
    if (strobe_q[15]) begin
      answer_last_q <= answer_late_q;
      part_last_q   <= part_late_q;
      both_last_q   <= both_q;
    end
    if (strobe_q[16]) begin
      case (part_last_q)
        PartReplace: result_o <= (answer_last_q & ~read_mask_i) | read_data_i;
        PartOr: result_o <= answer_last_q | read_data_i;
        PartCountLow: result_o <= counted[7:0];
        PartCountHigh: result_o <= answer_last_q + {7'd0, counter_carry_q};
        default: result_o <= answer_last_q;
      endcase
    end
  end

endmodule
