// Products of fp_product by its contract, against Verilog's own: corners, then random operands.
module product_tb;
  reg [23:0] a, b, corner[0:9];
  wire [47:0] outer;
  wire [23:0] low, high;
  wire [47:0] found = outer + ({24'd0, low} + {24'd0, high}) * 48'd131072;
  integer n, wrong, seed;

  fp_product dut (
      .a_i(a),
      .b_i(b),
      .outer_o(outer),
      .cross_low_o(low),
      .cross_high_o(high)
  );

  initial begin
    corner[0] = 24'h000000;
    corner[1] = 24'h000001;
    corner[2] = 24'h00ffff;
    corner[3] = 24'h01ffff;
    corner[4] = 24'h020000;
    corner[5] = 24'h7fffff;
    corner[6] = 24'h800000;
    corner[7] = 24'h800001;
    corner[8] = 24'hfe0000;
    corner[9] = 24'hffffff;
    wrong = 0;
    seed = 1;
    for (n = 0; n < 20000; n = n + 1) begin
      a = n < 100 ? corner[n/10] : $random(seed);
      b = n < 100 ? corner[n%10] : $random(seed);
      #1 if (found !== {24'd0, a} * {24'd0, b}) wrong = wrong + 1;
    end
    $display("%0d products, %0d wrong", n, wrong);
  end
endmodule
