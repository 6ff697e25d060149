// SPDX-License-Identifier: Apache-2.0
// n2_shadow: the core next to a machine without a pipeline that follows its trace, for bounded proofs.
// Contract: instructions come from free inputs (registers r0 to r3; kinds: make), one chosen address
// always holds the same word. bad_o: a retired instruction has another address, word, destination or
// value than the machine says. A register counts once it was written.
module n2_shadow (
    input  logic        clk_i,
    input  logic        resetn_i,
    input  logic [31:0] choice_i,   // what the fetched word is made of
    input  logic        done_i,     // end of a custom instruction
    output logic        bad_o,
    output logic        retired_o
);

  localparam logic [31:0] Base = 32'h1000_0000;

  logic fetch_en, start, combinational_unused;
  logic [3:0] fetch_address, watched_q, pc_q, next_pc;
  logic [31:0] word, fetched_q, watched_word_q, dataa, datab;
  logic valid, write, fault;
  logic [31:0] pc, instruction, value;
  logic [4:0] dst;

  // Instructions whose bit positions are independent: the proof is about forwarding, waiting and
  // redirection, not about adders. roli has a late result, custom one of any length.
  function automatic logic [31:0] make(input logic [31:0] x);
    logic [4:0] a, b, c;
    a = {3'd0, x[1:0]};
    b = {3'd0, x[3:2]};
    c = {3'd0, x[5:4]};
    case (x[8:6])
      3'd0: make = {a, b, c, 6'd30, 5'd0, 6'd58};             // xor
      3'd1: make = {a, b, c, 6'd6, 5'd0, 6'd58};              // nor
      3'd2: make = {a, 5'd0, c, 6'd2, 4'd0, x[16], 6'd58};    // roli by 0 or 1
      3'd3: make = {a, b, c, 3'b111, 8'd0, 6'd50};            // custom
      3'd4: make = {a, b, x[31:16], 6'd28};                   // xori
      3'd5: make = {a, b, x[31:16], 6'd38};                   // beq
      3'd6: make = {a, b, x[31:16], 6'd30};                   // bne
      default: make = {10'd0, x[31:16], 6'd6};                // br
    endcase
  endfunction

  assign word = fetch_address == watched_q ? watched_word_q : make(choice_i);
  always_ff @(posedge clk_i) begin
    if (fetch_en) fetched_q <= word;
    watched_q <= watched_q;
    if (!resetn_i) watched_word_q <= make(choice_i);
  end

  n2_core #(
      .ItcmBase(Base),
      .ItcmBytes(64),
      .DtcmBytes(64),
      .ResetVector(Base),
      .ExceptionVector(Base),
      .BreakVector(Base),
      .Trace(1)
  ) u_core (
      .clk_i              (clk_i),
      .rst_ni             (resetn_i),
      .itcm_en_o          (fetch_en),
      .itcm_address_o     (fetch_address),
      .itcm_rdata_i       (fetched_q),
      .itcm_data_rdata_i  (32'd0),
      .dtcm_rdata_i       (32'd0),
      .avm_readdata_i     (32'd0),
      .avm_waitrequest_i  (1'b0),
      .irq_i              (32'd0),
      .ci_combo_result_i  (32'd0),
      .debug_state_i      ('0),
      .debug_break_d_i    (1'b0),
      .debug_watch_e_i    (1'b0),
      .ci_multi_start_o   (start),
      .ci_multi_dataa_o   (dataa),
      .ci_multi_datab_o   (datab),
      .ci_multi_done_i    (done_i),
      .ci_multi_result_i  (dataa ^ ~datab),
      .trace_valid_o      (valid),
      .trace_pc_o         (pc),
      .trace_instruction_o(instruction),
      .trace_write_o      (write),
      .trace_dst_o        (dst),
      .trace_value_o      (value),
      .trace_exception_o  (fault)
  );
  assign combinational_unused = start;

  // The machine: registers, and what an instruction does to them.
  logic [31:0] r1_q, r2_q, r3_q, a, b, result;
  logic [3:0] known_q;
  logic writes, taken, known, link_free;
  logic [4:0] to;
  logic [5:0] op, opx;

  always_comb begin
    op = instruction[5:0];
    opx = instruction[16:11];
    case (instruction[28:27])
      2'd0: a = 32'd0;
      2'd1: a = r1_q;
      2'd2: a = r2_q;
      default: a = r3_q;
    endcase
    case (instruction[23:22])
      2'd0: b = 32'd0;
      2'd1: b = r1_q;
      2'd2: b = r2_q;
      default: b = r3_q;
    endcase
    writes = 1'b1;
    taken = 1'b0;
    to = op == 6'd58 || op == 6'd50 ? instruction[21:17] : instruction[26:22];
    known = known_q[instruction[28:27]];
    if (op == 6'd58 || op == 6'd50) known = known && known_q[instruction[23:22]];
    result = 32'd0;
    case (op)
      6'd58: begin
        case (opx)
          6'd30: result = a ^ b;
          6'd6:  result = ~(a | b);
          default: result = instruction[6] ? {a[30:0], a[31]} : a;
        endcase
      end
      6'd50: result = a ^ ~b;
      6'd28: result = a ^ {16'd0, instruction[21:6]};
      default: begin
        writes = 1'b0;
        known = known && known_q[instruction[23:22]];
        case (op)
          6'd38: taken = a == b;
          6'd30: taken = a != b;
          default: begin
            taken = 1'b1;
            known = 1'b1;
          end
        endcase
      end
    endcase
    next_pc = pc[5:2] + 4'd1;
    if (taken) next_pc = next_pc + instruction[11:8];
    writes = writes && to != 5'd0;
    link_free = pc[31:6] == Base[31:6] && pc[1:0] == 2'd0;
  end

  // A branch whose operands are not known may go either way: the machine then follows the core.
  logic follow_q;
  always_ff @(posedge clk_i) begin
    if (!resetn_i) begin
      pc_q     <= 4'd0;
      known_q  <= 4'b0001;
      follow_q <= 1'b0;
    end else if (valid) begin
      pc_q     <= next_pc;
      follow_q <= !writes && !known;
      if (writes) begin
        known_q[to[1:0]] <= known;
        case (to[1:0])
          2'd1: r1_q <= result;
          2'd2: r2_q <= result;
          default: r3_q <= result;
        endcase
      end
    end
  end

  assign bad_o = resetn_i && valid &&
                 (fault || !link_free || (!follow_q && pc[5:2] != pc_q) || write != writes ||
                  (writes && (dst != to || (known && value != result))) ||
                  (pc[5:2] == watched_q && instruction != watched_word_q));
  assign retired_o = valid;

endmodule
