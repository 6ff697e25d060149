// SPDX-License-Identifier: Apache-2.0
// asip_run: control of runs, with Resilience under the redundancy that makes a tick of several runs.
// Contract: that of asip_control; with Resilience that of asip_redundancy comes before it. rst_run_no resets
// issue and units: with rst_ni, and between runs.
module asip_run #(
    parameter int unsigned Bundles    = 1024,
    parameter int unsigned Resilience = 0
) (
    input  logic        clk_i,
    input  logic        rst_ni,
    output logic        rst_run_no,
    // from the host
    input  logic        start_i,
    input  logic        clear_i,
    input  logic        refetch_i,
    input  logic [31:0] watchdog_i,
    input  logic [31:0] output_mask_i,
    // from a debug block: counters hold, the run ends with the fault WATCHDOG
    input  logic        freeze_i,
    input  logic        abort_i,
    // from stage D
    input  logic        valid_d_i,
    input  logic        bad_d_i,         // illegal or outside program memory
    input  logic        pc_bad_d_i,      // of these, outside program memory
    input  logic        halt_d_i,
    input  logic [15:0] pc_d_i,
    input  logic        issue_i,
    input  logic        branch_wait_i,
    input  logic        stall_operand_i,
    input  logic        stall_unit_i,
    input  logic        output_d_i,
    input  logic [4:0]  output_index_d_i,
    // from R1 to E2 and write-back; not_finite_i comes a cycle after write-back
    input  logic        inflight_i,
    input  logic        busy_i,
    input  logic        address_fault_e2_i,
    input  logic [15:0] pc_e2_i,
    input  logic        not_finite_i,
    input  logic [4:0]  not_finite_index_i,
    // to issue, fetch and outputs
    output logic        run_o,
    output logic        run_next_o,
    output logic        refetch_o,
    output logic        run_start_o,
    output logic        commit_o,
    output logic        fault_o,
    output logic        ended_o,     // pulse, in the first clock after a run
    output logic        quiet_o,     // nothing was in flight in the cycle before
    // to the host
    output logic        busy_o,
    output logic        run_busy_o,  // one run
    output logic        done_o,
    output logic [3:0]  cause_o,
    output logic [15:0] fault_info_o,
    output logic [31:0] cycles_o,
    input  logic [2:0]  count_select_i,  // low bits of the register STALL_* or DRAIN
    output logic [31:0] count_o,         // .. in the next cycle
    // of redundancy: what the host writes, what a run writes, what is wrong
    input  logic        host_write_i,
    input  logic        host_register_i,
    input  logic [3:0]  wrote_i,         // output, banks C, B, A
    input  logic [2:0][5:0]  index_i,
    input  logic [2:0][31:0] result_i,
    input  logic        bad_program_i,   // P
    input  logic        bad_constant_i,  // E1
    input  logic        valid_e1_i,
    input  logic        bad_output_i,
    input  logic        broken_i,
    input  logic        checking_i,      // the verdict on an output is open
    input  logic        implausible_i,
    input  logic [4:0]  implausible_index_i,
    output asip_pkg::guard_t guard_o,
    output logic        repaired_o
);

  logic rst_control_n, start, refetch, busy, done, fault, commit, broken;
  logic [3:0] cause;
  logic [15:0] info;
  logic [31:0] cycles;

  asip_control #(
      .Resilience(Resilience)
  ) u_control (
      .rst_ni   (rst_control_n),
      .start_i  (start),
      .refetch_i(refetch),
      .commit_o (commit),
      .fault_o  (fault),
      .busy_o   (busy),
      .done_o   (done),
      .cause_o  (cause),
      .cycles_o (cycles),
      .fault_info_o(info),
      .broken_o (broken),
      .*
  );

  assign run_busy_o = busy;

  generate
    if (Resilience != 0) begin : gen_redundancy
      logic scrub, scrub_control, again, unused_commit;

      asip_redundancy #(
          .Bundles(Bundles)
      ) u_redundancy (
          .clk_i,
          .rst_ni,
          .start_i,
          .clear_i,
          .watchdog_i,
          .write_i         (host_write_i),
          .write_register_i(host_register_i),
          .start_o         (start),
          .scrub_o         (scrub),
          .scrub_control_o (scrub_control),
          .refetch_o       (again),
          .run_start_i     (run_start_o),
          .busy_i          (busy),
          .done_i          (done),
          .fault_i         (fault),
          .cause_i         (cause),
          .broken_run_i    (broken),
          .wrote_i,
          .index_i,
          .result_i,
          .bad_program_i,
          .bad_constant_i,
          .valid_e1_i,
          .bad_output_i,
          .broken_i,
          .checking_i,
          .implausible_i,
          .guard_o,
          .commit_o,
          .busy_o,
          .done_o,
          .fault_o,
          .cause_o,
          .repaired_o,
          .cycles_o
      );
      assign refetch       = refetch_i || again;
      assign rst_run_no    = rst_ni && !scrub;
      assign rst_control_n = rst_ni && !scrub_control;
      assign fault_info_o  = cause_o == asip_regmap_pkg::FAULT_IMPLAUSIBLE
                           ? {11'd0, implausible_index_i} : info;
      assign unused_commit = ^{commit, cycles};
    end else begin : gen_once
      logic unused_redundancy;
      assign rst_control_n = rst_ni;
      assign rst_run_no    = rst_ni;
      assign start         = start_i;
      assign refetch       = refetch_i;
      assign commit_o      = commit;
      assign fault_o       = fault;
      assign busy_o        = busy;
      assign done_o        = done;
      assign cause_o       = cause;
      assign cycles_o      = cycles;
      assign fault_info_o  = info;
      assign guard_o       = '0;
      assign repaired_o    = 1'b0;
      assign unused_redundancy = ^{host_write_i, host_register_i, wrote_i, index_i, result_i,
                                 bad_program_i, bad_constant_i, valid_e1_i, bad_output_i, broken_i,
                                 broken, checking_i, implausible_i, implausible_index_i};
    end
  endgenerate

endmodule
