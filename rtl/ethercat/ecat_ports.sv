// SPDX-License-Identifier: Apache-2.0
// ecat_ports: loop control of the two ports: which way frames go.
// Contract: frames go port 0 - processing - port 1, and from port 1 back to port 0. A closed port hands what would leave by it
// on inside: closed port 1, processing - port 0; closed port 0, port 1 - processing - port 1. The way from port 1 to
// port 0 takes as long as processing, so that half of a round trip is the way there. A loop changes only while no frame passes. An open port without a link loses what is sent there.
module ecat_ports (
    input  logic       clk_i,
    input  logic       rst_ni,
    input  logic       tick_i,
    input  logic [1:0] link_i,
    input  logic [3:0] control_i,    // two bits a port: 0 auto, 1 auto close, 2 open, 3 closed
    input  logic       anew_i,       // the control is written
    output logic [1:0] open_o,
    output logic       looped_o,     // the processing unit hears port 1
    output logic [1:0] lost_o,       // a link went
    input  ecat_pkg::nibble_t receive_0_i,
    input  ecat_pkg::nibble_t receive_1_i,
    output ecat_pkg::nibble_t to_unit_o,
    input  ecat_pkg::nibble_t from_unit_i,
    output ecat_pkg::nibble_t send_0_o,
    output ecat_pkg::nibble_t send_1_o
);

  localparam logic [4:0] Quiet = 5'd16;  // ticks, above the unit's delay

  localparam int unsigned Delay = 9;  // ticks, the unit's

  logic [1:0] open_q, link_q, want, kept_q;
  logic [3:0] back_data_q[0:Delay-1];
  logic [Delay-1:0] back_q;
  ecat_pkg::nibble_t back;
  logic [4:0] quiet_q;
  logic looped, busy;

  // auto close: once closed by a lost link, a port opens again when its control is written again.
  genvar p;
  generate
    for (p = 0; p < 2; p++) begin : gen_port
      logic [1:0] control;
      assign control = control_i[2*p+:2];
      always_comb begin
        case (control)
          2'd0: want[p] = link_i[p];
          2'd1: want[p] = link_i[p] && kept_q[p];
          2'd2: want[p] = 1'b1;
          default: want[p] = 1'b0;
        endcase
      end
      always_ff @(posedge clk_i or negedge rst_ni) begin
        if (!rst_ni) kept_q[p] <= 1'b1;
        else if (control != 2'd1 || anew_i) kept_q[p] <= 1'b1;
        else if (!link_i[p]) kept_q[p] <= 1'b0;
      end
    end
  endgenerate

  always_ff @(posedge clk_i) begin
    if (tick_i) begin
      for (int i = 0; i < Delay; i++) back_data_q[i] <= i == 0 ? receive_1_i.data : back_data_q[i-1];
    end
  end
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) back_q <= '0;
    else if (tick_i) back_q <= {back_q[Delay-2:0], receive_1_i.valid};
  end
  assign back = {back_q[Delay-1], 1'b0, back_data_q[Delay-1]};

  assign busy = receive_0_i.valid || receive_1_i.valid || from_unit_i.valid || back.valid;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      open_q  <= '0;
      link_q  <= '0;
      quiet_q <= '0;
    end else begin
      link_q <= link_i;
      if (busy) quiet_q <= '0;
      else if (tick_i && quiet_q != Quiet) quiet_q <= quiet_q + 1'b1;
      if (quiet_q == Quiet && !busy) open_q <= want;
    end
  end

  assign looped    = !open_q[0] && open_q[1];
  assign looped_o  = looped;
  assign open_o    = open_q;
  assign lost_o    = link_q & ~link_i;
  assign to_unit_o = looped ? receive_1_i : receive_0_i;
  always_comb begin
    send_0_o = '0;
    send_1_o = '0;
    if (open_q[1]) send_1_o = from_unit_i;
    else if (open_q[0]) send_0_o = from_unit_i;
    if (open_q[0] && open_q[1]) send_0_o = back;
  end

endmodule
