// SPDX-License-Identifier: Apache-2.0
// asip_sva: the core's Avalon-MM port, and one unit per operation that reaches stage E1.
module asip_sva #(
    parameter int unsigned Slots = 1
) (
    input logic                                      clk_i,
    input logic                                      rst_ni,
    input logic                                      valid_e1_q,
    input logic [Slots*asip_pkg::DECODED_WIDTH-1:0]  ops_e1_q,
    input logic                                      issue,
    input logic                                      bad_d,
    input logic                                      busy,
    input logic                                      host_hold,
    input logic                                      hook_open
);

  for (genvar s = 0; s < Slots; s++) begin : gen_slot
    asip_pkg::decoded_t op;
    assign op = ops_e1_q[asip_pkg::DECODED_WIDTH*s+:asip_pkg::DECODED_WIDTH];

    OneUnit : assert property (@(posedge clk_i) disable iff (!rst_ni)
        valid_e1_q |-> !op.illegal &&
        $onehot0({op.fma, op.cmp, op.divsqrt, op.i2f, op.f2i, op.sincos, op.load, op.store, op.jump,
                  op.branch_zero, op.branch_nonzero}))
    else $error("an operation for two units, or an illegal one, was executed");
  end

  GoodBundle : assert property (@(posedge clk_i) disable iff (!rst_ni)
      issue |-> !bad_d)
  else $error("an illegal bundle issued");

  // With asip_host_sva: memories are written and read while idle or halted only.
  RunUndisturbed : assert property (@(posedge clk_i) disable iff (!rst_ni)
      busy && !hook_open |-> host_hold)
  else $error("the host may access memories during a run");

endmodule

bind asip asip_sva #(
    .Slots(Slots)
) u_sva (
    .hook_open(hook.open),
    .*
);

bind asip avalon_rules #(
    .AddressWidth(asip_regmap_pkg::ADDRESS_WIDTH)
) u_avalon (
    .clk_i,
    .rst_ni,
    .address    (address_i),
    .read       (read_i),
    .write      (write_i),
    .writedata  (writedata_i),
    .waitrequest(waitrequest_o)
);
