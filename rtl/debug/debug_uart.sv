// SPDX-License-Identifier: Apache-2.0
// debug_uart: bytes on a serial line, 8 data bits, no parity, one stop bit.
// Contract: a bit takes divider_i clocks, 4 at least. data_i is taken in a clock with send_i and ready_o.
// received_o is a pulse in the middle of a stop bit that is high; broken_o, of one that is low.
module debug_uart (
    input  logic        clk_i,
    input  logic        rst_ni,
    input  logic [15:0] divider_i,
    // line
    input  logic        rx_i,
    output logic        tx_o,
    // bytes out
    input  logic        send_i,
    input  logic [7:0]  data_i,
    output logic        ready_o,
    // bytes in
    output logic        received_o,
    output logic        broken_o,
    output logic [7:0]  data_o
);

  // ---- transmit: start bit, 8 bits, stop bit
  logic [9:0] out_q;
  logic [3:0] out_left_q;
  logic [15:0] out_clocks_q;
  logic out_tick;

  assign ready_o  = out_left_q == 4'd0;
  assign out_tick = out_clocks_q == 16'd0;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      out_q        <= '1;
      out_left_q   <= 4'd0;
      out_clocks_q <= '0;
    end else if (ready_o) begin
      if (send_i) begin
        out_q        <= {1'b1, data_i, 1'b0};
        out_left_q   <= 4'd10;
        out_clocks_q <= divider_i - 16'd1;
      end
    end else if (out_tick) begin
      out_q        <= {1'b1, out_q[9:1]};
      out_left_q   <= out_left_q - 4'd1;
      out_clocks_q <= divider_i - 16'd1;
    end else begin
      out_clocks_q <= out_clocks_q - 16'd1;
    end
  end

  assign tx_o = out_q[0];

  // ---- receive: a low line starts a byte, bits are taken in their middle
  logic [1:0] line_q;
  logic [7:0] in_q;
  logic [3:0] in_left_q;  // 10: the start bit
  logic [15:0] in_clocks_q;
  logic received_q, broken_q, idle_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      line_q      <= '1;
      in_q        <= '0;
      in_left_q   <= 4'd0;
      in_clocks_q <= '0;
      received_q  <= 1'b0;
      broken_q    <= 1'b0;
      idle_q      <= 1'b0;
    end else begin
      line_q     <= {line_q[0], rx_i};
      received_q <= 1'b0;
      broken_q   <= 1'b0;
      if (in_left_q == 4'd0) begin
        // a byte starts with an edge: after a broken stop bit the line must be high first
        if (line_q[1]) idle_q <= 1'b1;
        if (idle_q && !line_q[1]) begin
          in_left_q   <= 4'd10;
          in_clocks_q <= {1'b0, divider_i[15:1]};
        end
      end else if (in_clocks_q == 16'd0) begin
        in_clocks_q <= divider_i - 16'd1;
        in_left_q   <= in_left_q - 4'd1;
        in_q        <= {line_q[1], in_q[7:1]};
        if (in_left_q == 4'd10 && line_q[1]) in_left_q <= 4'd0;  // no start bit: a glitch
        if (in_left_q == 4'd1) begin
          in_q       <= in_q;
          received_q <= line_q[1];
          broken_q   <= !line_q[1];
          idle_q     <= line_q[1];
        end
      end else begin
        in_clocks_q <= in_clocks_q - 16'd1;
      end
    end
  end

  assign received_o = received_q;
  assign broken_o   = broken_q;
  assign data_o     = in_q;

endmodule
