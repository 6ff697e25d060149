// SPDX-License-Identifier: Apache-2.0
// n2_control: control registers of stage M and the interrupt request.
// Contract: one event per cycle in which strobe_i is high: a fault (its entry), a return, a wrctl. Of
// status, estatus and bstatus only PIE exists. ipending, cpuid and exception ignore writes. interrupt_o
// is registered: it follows a change of PIE or ienable a cycle later, before the next instruction
// (fetched again after every such change) is decoded.
module n2_control #(
    parameter logic [31:0] CpuId = 32'd0
) (
    input  logic        clk_i,
    input  logic        rst_ni,
    input  logic        strobe_i,
    input  logic        fault_i,
    input  logic        breakpoint_i,  // with fault_i
    input  logic [4:0]  cause_i,
    input  logic [31:0] badaddr_i,
    input  logic        leave_i,
    input  logic        leave_break_i, // with leave_i
    input  logic        wrctl_i,
    input  logic [4:0]  number_i,
    input  logic [31:0] value_i,
    output logic [31:0] read_o,
    input  logic [31:0] irq_i,
    output logic        interrupt_o,
    output logic        estatus_o,
    output logic [31:0] ipending_o
);

  logic pie_q, epie_q, bpie_q, interrupt_q;
  logic [31:0] ienable_q, badaddr_q, ipending;
  logic [4:0] cause_q;
  logic faulty_address;

  assign ipending = irq_i & ienable_q;
  assign faulty_address = cause_i == n2_isa_pkg::CAUSE_DATA_ADDRESS ||
                          cause_i == n2_isa_pkg::CAUSE_TARGET_ADDRESS;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      pie_q       <= 1'b0;
      epie_q      <= 1'b0;
      bpie_q      <= 1'b0;
      ienable_q   <= 32'd0;
      cause_q     <= n2_isa_pkg::CAUSE_RESET;
      badaddr_q   <= 32'd0;
      interrupt_q <= 1'b0;
    end else begin
      interrupt_q <= pie_q && ipending != 32'd0;
      if (strobe_i) begin
        if (fault_i) begin
          pie_q <= 1'b0;
          if (breakpoint_i) bpie_q <= pie_q;
          else begin
            epie_q  <= pie_q;
            cause_q <= cause_i;
            if (faulty_address) badaddr_q <= badaddr_i;
          end
        end else if (leave_i) begin
          pie_q <= leave_break_i ? bpie_q : epie_q;
        end else if (wrctl_i) begin
          case (number_i)
            n2_isa_pkg::CTL_STATUS:  pie_q <= value_i[0];
            n2_isa_pkg::CTL_ESTATUS: epie_q <= value_i[0];
            n2_isa_pkg::CTL_BSTATUS: bpie_q <= value_i[0];
            n2_isa_pkg::CTL_IENABLE: ienable_q <= value_i;
            n2_isa_pkg::CTL_BADADDR: badaddr_q <= value_i;
            default: ;
          endcase
        end
      end
    end
  end

  always_comb begin
    case (number_i)
      n2_isa_pkg::CTL_STATUS:    read_o = {31'd0, pie_q};
      n2_isa_pkg::CTL_ESTATUS:   read_o = {31'd0, epie_q};
      n2_isa_pkg::CTL_BSTATUS:   read_o = {31'd0, bpie_q};
      n2_isa_pkg::CTL_IENABLE:   read_o = ienable_q;
      n2_isa_pkg::CTL_IPENDING:  read_o = ipending;
      n2_isa_pkg::CTL_CPUID:     read_o = CpuId;
      n2_isa_pkg::CTL_EXCEPTION: read_o = {25'd0, cause_q, 2'd0};
      n2_isa_pkg::CTL_BADADDR:   read_o = badaddr_q;
      default:                   read_o = 32'd0;
    endcase
  end

  assign interrupt_o = interrupt_q;
  assign estatus_o   = epie_q;
  assign ipending_o  = ipending;

endmodule
