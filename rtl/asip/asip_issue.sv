// SPDX-License-Identifier: Apache-2.0
// asip_issue: hazard interlocks and write schedules (stages P, Q and D), for one slot or several.
// Contract: a bundle issues, all its operations together, in the first cycle in which every source and
// destination has no write in flight (a write ends for a reader latency + 1 cycles after its issue),
// the write port of bank C is free in the cycle its auxiliary result needs it, its units take an operation,
// and no branch is undecided. Any program is therefore correct whatever its schedule.
// The decision is made in the cycle before, for the bundle that will be in D, so that issue_o and
// advance_o are registers. One slot has few writes in flight and needs no scoreboards.
module asip_issue #(
    parameter int unsigned FmaPipes = 2,
    parameter int unsigned Slots    = 3
) (
    input  logic                                           clk_i,
    input  logic                                           rst_ni,
    // from fetch
    input  logic                                           flush_i,   // P, Q and D are void
    input  logic [Slots*asip_pkg::DECODED_WIDTH-1:0]       ops_p_i,
    input  logic                                           valid_q_i,
    input  logic                                           bad_q_i,   // must not issue
    input  logic [Slots*asip_pkg::DECODED_WIDTH-1:0]       ops_q_i,
    input  logic                                           valid_d_i,
    input  logic                                           bad_d_i,
    input  logic [Slots*asip_pkg::DECODED_WIDTH-1:0]       ops_d_i,
    // from control: the core runs, it will run in the next cycle
    input  logic                                           run_i,
    input  logic                                           run_next_i,
    // to fetch, control and the operand stage
    output logic                                           advance_o,
    output logic                                           issue_o,
    output logic                                           branch_wait_o,
    output logic                                           branch_e1_o,
    output logic                                           stall_operand_o,
    output logic                                           stall_unit_o,
    output logic [3*Slots-1:0][8:0]                        source_d_o,
    // to the operand stage and write-back: banks A, B, C in two cycles, in the next cycle, now
    output logic [2:0]                                     soon_o,
    output logic [2:0][5:0]                                soon_index_o,
    output logic [2:0]                                     next_o,
    output logic [2:0][5:0]                                next_index_o,
    output logic [2:0]                                     write_o,
    output logic [2:0][5:0]                                write_index_o,
    output logic                                           write_output_o,
    output logic                                           busy_o
);

  // The ports are the same, name by name.
  generate
    if (Slots == 1) begin : gen_single
      asip_issue_single u_issue (.*);
    end else begin : gen_multiple
      asip_issue_multiple #(
          .FmaPipes(FmaPipes),
          .Slots   (Slots)
      ) u_issue (
          .*
      );
    end
  endgenerate

endmodule
