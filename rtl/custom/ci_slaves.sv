// SPDX-License-Identifier: Apache-2.0
// ci_slaves: custom instructions of a platform at the two masters of the CPU, which the vendor's
// tool generates otherwise. Platform 1: vendor FPU (ci_fph1); 2: ours. Numbers: ci_pkg.
// Contract: combo_result_o follows its operands. multi_start_i is high in the first cycle only, the
// operands are held until multi_done_o; the result is taken at the rising edge that sees done and
// clk_en high. A number without a component ends in its start cycle with result 0.
module ci_slaves #(
    parameter int unsigned Platform = 2
) (
    input  logic        multi_clk_i,
    input  logic        multi_reset_i,     // active high, asynchronous, released with the clock

    // combinational group, from the execute stage
    input  logic [31:0] combo_dataa_i,
    input  logic [31:0] combo_datab_i,
    input  logic [7:0]  combo_n_i,
    input  logic        combo_readra_i,
    input  logic        combo_readrb_i,
    input  logic        combo_writerc_i,
    input  logic [4:0]  combo_a_i,
    input  logic [4:0]  combo_b_i,
    input  logic [4:0]  combo_c_i,
    output logic [31:0] combo_result_o,

    // multicycle group
    input  logic        multi_clk_en_i,
    input  logic        multi_start_i,
    input  logic [31:0] multi_dataa_i,
    input  logic [31:0] multi_datab_i,
    input  logic [7:0]  multi_n_i,
    input  logic        multi_readra_i,
    input  logic        multi_readrb_i,
    input  logic        multi_writerc_i,
    input  logic [4:0]  multi_a_i,
    input  logic [4:0]  multi_b_i,
    input  logic [4:0]  multi_c_i,
    output logic        multi_done_o,
    output logic [31:0] multi_result_o
);

  generate
    if (Platform == 1) begin : gen_fpga1

      logic mine, done;
      logic [31:0] result;
      assign mine = multi_n_i[7:2] == ci_pkg::FPGA1_FPH1_BASE[7:2];
      ci_fph1 u_fph1 (
          .clk_i   (multi_clk_i),
          .reset_i (multi_reset_i),
          .clk_en_i(multi_clk_en_i),
          .start_i (multi_start_i && mine),
          .n_i     (multi_n_i[1:0]),
          .dataa_i (multi_dataa_i),
          .datab_i (multi_datab_i),
          .done_o  (done),
          .result_o(result)
      );
      assign multi_done_o   = mine ? done : multi_start_i;
      assign multi_result_o = mine ? result : 32'd0;
      assign combo_result_o = 32'd0;

      logic unused_combo, unused_multi;
      assign unused_combo = ^{combo_dataa_i, combo_datab_i, combo_n_i};
      assign unused_multi = ^{multi_readra_i, multi_readrb_i, multi_writerc_i,
                            multi_a_i, multi_b_i, multi_c_i};

    end else begin : gen_fpga2

      // ---- combinational group ----
      logic [31:0] compared, sign;
      ci_fcmp u_fcmp (
          .dataa_i (combo_dataa_i),
          .datab_i (combo_datab_i),
          .n_i     (combo_n_i[3:0]),
          .result_o(compared)
      );
      ci_fsign u_fsign (
          .dataa_i (combo_dataa_i),
          .result_o(sign)
      );
      always_comb begin
        combo_result_o = 32'd0;
        if (combo_n_i[7:4] == ci_pkg::FPGA2_FCMP_BASE[7:4]) combo_result_o = compared;
        if (combo_n_i == ci_pkg::FPGA2_N_FSIGN) combo_result_o = sign;
      end

      // ---- multicycle group: pairs of instructions share a unit ----
      logic [31:0] sum, product, quotient, wave, limited, floated, fixed;
      logic wave_mine, limit_mine;
      assign wave_mine  = multi_n_i == ci_pkg::FPGA2_N_FSIN || multi_n_i == ci_pkg::FPGA2_N_FCOS;
      assign limit_mine = multi_n_i == ci_pkg::FPGA2_N_FSAT;
      ci_faddsub u_faddsub (
          .clk_i   (multi_clk_i),
          .reset_i (multi_reset_i),
          .clk_en_i(multi_clk_en_i),
          .start_i (multi_start_i),
          .n_i     (multi_n_i == ci_pkg::FPGA2_N_FSUB),
          .dataa_i (multi_dataa_i),
          .datab_i (multi_datab_i),
          .result_o(sum)
      );
      ci_fmul u_fmul (
          .clk_i   (multi_clk_i),
          .reset_i (multi_reset_i),
          .clk_en_i(multi_clk_en_i),
          .start_i (multi_start_i),
          .dataa_i (multi_dataa_i),
          .datab_i (multi_datab_i),
          .result_o(product)
      );
      ci_fdivsqrt u_fdivsqrt (
          .clk_i   (multi_clk_i),
          .reset_i (multi_reset_i),
          .clk_en_i(multi_clk_en_i),
          .start_i (multi_start_i),
          .n_i     (multi_n_i == ci_pkg::FPGA2_N_FSQRT),
          .dataa_i (multi_dataa_i),
          .datab_i (multi_datab_i),
          .result_o(quotient)
      );
      ci_fsincos u_fsincos (
          .clk_i   (multi_clk_i),
          .reset_i (multi_reset_i),
          .clk_en_i(multi_clk_en_i),
          .start_i (multi_start_i && wave_mine),
          .n_i     (multi_n_i == ci_pkg::FPGA2_N_FCOS),
          .dataa_i (multi_dataa_i),
          .result_o(wave)
      );
      ci_fsat u_fsat (
          .clk_i    (multi_clk_i),
          .reset_i  (multi_reset_i),
          .clk_en_i (multi_clk_en_i),
          .start_i  (multi_start_i && limit_mine),
          .dataa_i  (multi_dataa_i),
          .datab_i  (multi_datab_i),
          .readra_i (multi_readra_i),
          .readrb_i (multi_readrb_i),
          .writerc_i(multi_writerc_i),
          .a_i      (multi_a_i),
          .b_i      (multi_b_i),
          .c_i      (multi_c_i),
          .result_o (limited)
      );
      ci_floatis u_floatis (
          .clk_i   (multi_clk_i),
          .reset_i (multi_reset_i),
          .clk_en_i(multi_clk_en_i),
          .start_i (multi_start_i),
          .dataa_i (multi_dataa_i),
          .result_o(floated)
      );
      ci_fixsi u_fixsi (
          .clk_i   (multi_clk_i),
          .reset_i (multi_reset_i),
          .clk_en_i(multi_clk_en_i),
          .start_i (multi_start_i),
          .dataa_i (multi_dataa_i),
          .result_o(fixed)
      );

      // ---- cycles of the instruction, start cycle included, and the unit whose result it takes ----
      logic [5:0] cycles;
      logic [6:0] mine, mine_q;
      always_comb begin
        cycles = 6'd1;
        mine   = 7'd0;
        case (multi_n_i)
          ci_pkg::FPGA2_N_FADD, ci_pkg::FPGA2_N_FSUB: begin
            cycles = 6'(ci_pkg::FPGA2_FADD_CYCLES);
            mine[0] = 1'b1;
          end
          ci_pkg::FPGA2_N_FMUL: begin
            cycles = 6'(ci_pkg::FPGA2_FMUL_CYCLES);
            mine[1] = 1'b1;
          end
          ci_pkg::FPGA2_N_FDIV, ci_pkg::FPGA2_N_FSQRT: begin
            cycles = 6'(ci_pkg::FPGA2_FDIV_CYCLES);
            mine[2] = 1'b1;
          end
          ci_pkg::FPGA2_N_FSIN, ci_pkg::FPGA2_N_FCOS: begin
            cycles = 6'(ci_pkg::FPGA2_FSIN_CYCLES);
            mine[3] = 1'b1;
          end
          ci_pkg::FPGA2_N_FSAT: begin
            cycles = 6'(ci_pkg::FPGA2_FSAT_CYCLES);
            mine[4] = 1'b1;
          end
          ci_pkg::FPGA2_N_FLOATIS: begin
            cycles = 6'(ci_pkg::FPGA2_FLOATIS_CYCLES);
            mine[5] = 1'b1;
          end
          ci_pkg::FPGA2_N_FIXSI: begin
            cycles = 6'(ci_pkg::FPGA2_FIXSI_CYCLES);
            mine[6] = 1'b1;
          end
          default: ;
        endcase
      end

      // left_q: cycles that are left, this one included; 0 when idle. last_q: one is left. Nothing
      // decodes a number on the way of a result, since none comes in the start cycle.
      logic rst_n, last_q;
      logic [5:0] left_q;
      assign rst_n = !multi_reset_i;
      always_ff @(posedge multi_clk_i or negedge rst_n) begin
        if (!rst_n) begin
          left_q <= 6'd0;
          last_q <= 1'b0;
          mine_q <= 7'd0;
        end else if (multi_clk_en_i) begin
          if (multi_start_i) left_q <= cycles - 6'd1;
          else if (left_q != 6'd0) left_q <= left_q - 6'd1;
          last_q <= (multi_start_i ? cycles : left_q) == 6'd2;
          if (multi_start_i) mine_q <= mine;
          else if (last_q) mine_q <= 7'd0;
        end
      end
      assign multi_done_o   = multi_start_i ? cycles == 6'd1 : last_q;
      assign multi_result_o = ({32{mine_q[0]}} & sum) |
                         ({32{mine_q[1]}} & product) |
                         ({32{mine_q[2]}} & quotient) |
                         ({32{mine_q[3]}} & wave) |
                         ({32{mine_q[4]}} & limited) |
                         ({32{mine_q[5]}} & floated) |
                         ({32{mine_q[6]}} & fixed);

    end
  endgenerate

  logic unused_registers;
  assign unused_registers = ^{combo_readra_i, combo_readrb_i, combo_writerc_i, combo_a_i, combo_b_i, combo_c_i};

`ifndef SYNTHESIS
  generate
    if (Platform != 1 && Platform != 2) begin : gen_check
      $error("ci_slaves: Platform=%0d, must be 1 (vendor FPU) or 2 (ours)", Platform);
    end
  endgenerate
`endif

endmodule
