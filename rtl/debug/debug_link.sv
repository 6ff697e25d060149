// SPDX-License-Identifier: Apache-2.0
// debug_link: the serial port of the debug block: line, packets, requests on the bus.
// Contract: that of debug_serve; docs/debug_block.md. The line takes 8 data bits, no parity, one stop bit,
// UART.divider clocks a bit, Divider after reset.
module debug_link #(
    parameter int unsigned RingLog2 = 12,
    parameter logic [15:0] Divider  = 16'd868
) (
    input  logic                clk_i,
    input  logic                rst_ni,
    // line
    input  logic                rx_i,
    output logic                tx_o,
    // writes of registers
    input  logic                csr_write_i,
    input  logic [5:0]          csr_index_i,
    input  logic [31:0]         csr_data_i,
    // from the registers and the scope
    input  logic [31:0]         status_i,
    input  logic [31:0]         place_i,
    input  logic [31:0]         runs_i,
    input  logic [31:0]         records_i,
    input  logic [2:0]          last_channel_i,
    input  logic [1:0]          size_log2_i,
    input  logic                armed_i,
    output logic [31:0]         errors_o,
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

  logic [15:0] divider_q, dropped_q, lost;
  logic stream_q, events_q;
  logic line_send, line_ready, received, broken, dropped;
  logic [7:0] line_out, line_in, request_byte, packet_byte;
  logic request, done, packet_ready, put, finish;
  logic [5:0] length, index;

  logic serve_read, serve_write, serve_wait;
  logic [14:0] serve_address;
  logic [31:0] serve_data, serve_answer;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      divider_q <= Divider;
      stream_q  <= 1'b0;
      events_q  <= 1'b0;
      dropped_q <= '0;
    end else begin
      if (csr_write_i && csr_index_i == debug_regmap_pkg::REG_UART) begin
        divider_q <= csr_data_i[debug_regmap_pkg::UART_DIVIDER_LSB+:16];
        stream_q  <= csr_data_i[debug_regmap_pkg::UART_STREAM_LSB];
        events_q  <= csr_data_i[debug_regmap_pkg::UART_EVENTS_LSB];
      end
      if (dropped) dropped_q <= dropped_q + 16'd1;
    end
  end

  debug_uart u_uart (
      .clk_i,
      .rst_ni,
      .divider_i (divider_q),
      .rx_i,
      .tx_o,
      .send_i    (line_send),
      .data_i    (line_out),
      .ready_o   (line_ready),
      .received_o(received),
      .broken_o  (broken),
      .data_o    (line_in)
  );

  debug_receive u_receive (
      .clk_i,
      .rst_ni,
      .received_i(received),
      .broken_i  (broken),
      .data_i    (line_in),
      .request_o (request),
      .length_o  (length),
      .index_i   (index),
      .data_o    (request_byte),
      .done_i    (done),
      .dropped_o (dropped)
  );

  debug_serve #(
      .RingLog2(RingLog2)
  ) u_serve (
      .clk_i,
      .rst_ni,
      .stream_i      (stream_q),
      .events_i      (events_q),
      .status_i,
      .place_i,
      .runs_i,
      .records_i,
      .last_channel_i,
      .size_log2_i,
      .armed_i,
      .lost_o        (lost),
      .request_i     (request),
      .length_i      (length),
      .index_o       (index),
      .byte_i        (request_byte),
      .done_o        (done),
      .ready_i       (packet_ready),
      .put_o         (put),
      .data_o        (packet_byte),
      .end_o         (finish),
      .read_o        (serve_read),
      .write_o       (serve_write),
      .address_o     (serve_address),
      .writedata_o   (serve_data),
      .readdata_i    (serve_answer),
      .wait_i        (serve_wait),
      .ring_taken_i,
      .ring_address_o,
      .ring_data_i
  );

  debug_send u_send (
      .clk_i,
      .rst_ni,
      .ready_o(packet_ready),
      .put_i  (put),
      .data_i (packet_byte),
      .end_i  (finish),
      .send_o (line_send),
      .data_o (line_out),
      .ready_i(line_ready)
  );

  // The line is slow, the ways over the bus are long.
  debug_bus_slice #(
      .AddressWidth(15)
  ) u_slice (
      .clk_i,
      .rst_ni,
      .read_i         (serve_read),
      .write_i        (serve_write),
      .address_i      (serve_address),
      .writedata_i    (serve_data),
      .readdata_o     (serve_answer),
      .waitrequest_o  (serve_wait),
      .far_read_o     (read_o),
      .far_write_o    (write_o),
      .far_address_o  (address_o),
      .far_writedata_o(writedata_o),
      .far_readdata_i (readdata_i),
      .far_wait_i     (wait_i)
  );

  assign errors_o = {lost, dropped_q};

endmodule
