// SPDX-License-Identifier: Apache-2.0
// Models of the ECP5 cells for which Yosys has none that can run: block RAM and multiplier. The others are
// in Yosys's own share/ecp5/cells_sim.v.
// Written from Lattice's FPGA-TN-02204 (memory) and FPGA-TN-02205 (sysDSP), for what synth_ecp5 makes of our
// RTL: no output registers, no chip selects, multipliers without registers.
// RESETMODE makes no difference here: no reset of an output is used, and a design that uses one is stopped.
// 2048 memory of 9 bits. A port of 18 or 36 bits has unit enables in its lowest address bits; ports of 1, 2
// and 4 bits use the lower 8 bits of a unit. A unit that one port reads while the other one writes it reads
// inverted: the device promises nothing there, so no design may use it.
module DP16KD (
    input DIA17, DIA16, DIA15, DIA14, DIA13, DIA12, DIA11, DIA10, DIA9, DIA8, DIA7, DIA6, DIA5, DIA4, DIA3, DIA2, DIA1, DIA0,
    input ADA13, ADA12, ADA11, ADA10, ADA9, ADA8, ADA7, ADA6, ADA5, ADA4, ADA3, ADA2, ADA1, ADA0,
    input CEA, OCEA, CLKA, WEA, RSTA, CSA2, CSA1, CSA0,
    output DOA17, DOA16, DOA15, DOA14, DOA13, DOA12, DOA11, DOA10, DOA9, DOA8, DOA7, DOA6, DOA5, DOA4, DOA3, DOA2, DOA1, DOA0,
    input DIB17, DIB16, DIB15, DIB14, DIB13, DIB12, DIB11, DIB10, DIB9, DIB8, DIB7, DIB6, DIB5, DIB4, DIB3, DIB2, DIB1, DIB0,
    input ADB13, ADB12, ADB11, ADB10, ADB9, ADB8, ADB7, ADB6, ADB5, ADB4, ADB3, ADB2, ADB1, ADB0,
    input CEB, OCEB, CLKB, WEB, RSTB, CSB2, CSB1, CSB0,
    output DOB17, DOB16, DOB15, DOB14, DOB13, DOB12, DOB11, DOB10, DOB9, DOB8, DOB7, DOB6, DOB5, DOB4, DOB3, DOB2, DOB1, DOB0
);
  parameter DATA_WIDTH_A = 18, DATA_WIDTH_B = 18;
  parameter REGMODE_A = "NOREG", REGMODE_B = "NOREG", RESETMODE = "SYNC", ASYNC_RESET_RELEASE = "SYNC";
  parameter CSDECODE_A = "0b000", CSDECODE_B = "0b000", GSR = "AUTO";
  parameter WRITEMODE_A = "NORMAL", WRITEMODE_B = "NORMAL", CLKAMUX = "CLKA", CLKBMUX = "CLKB";
  parameter [319:0] // 16 words of 18 bits, 20 bits apart
    INITVAL_00 = 0, INITVAL_01 = 0, INITVAL_02 = 0, INITVAL_03 = 0,
    INITVAL_04 = 0, INITVAL_05 = 0, INITVAL_06 = 0, INITVAL_07 = 0,
    INITVAL_08 = 0, INITVAL_09 = 0, INITVAL_0A = 0, INITVAL_0B = 0,
    INITVAL_0C = 0, INITVAL_0D = 0, INITVAL_0E = 0, INITVAL_0F = 0,
    INITVAL_10 = 0, INITVAL_11 = 0, INITVAL_12 = 0, INITVAL_13 = 0,
    INITVAL_14 = 0, INITVAL_15 = 0, INITVAL_16 = 0, INITVAL_17 = 0,
    INITVAL_18 = 0, INITVAL_19 = 0, INITVAL_1A = 0, INITVAL_1B = 0,
    INITVAL_1C = 0, INITVAL_1D = 0, INITVAL_1E = 0, INITVAL_1F = 0,
    INITVAL_20 = 0, INITVAL_21 = 0, INITVAL_22 = 0, INITVAL_23 = 0,
    INITVAL_24 = 0, INITVAL_25 = 0, INITVAL_26 = 0, INITVAL_27 = 0,
    INITVAL_28 = 0, INITVAL_29 = 0, INITVAL_2A = 0, INITVAL_2B = 0,
    INITVAL_2C = 0, INITVAL_2D = 0, INITVAL_2E = 0, INITVAL_2F = 0,
    INITVAL_30 = 0, INITVAL_31 = 0, INITVAL_32 = 0, INITVAL_33 = 0,
    INITVAL_34 = 0, INITVAL_35 = 0, INITVAL_36 = 0, INITVAL_37 = 0,
    INITVAL_38 = 0, INITVAL_39 = 0, INITVAL_3A = 0, INITVAL_3B = 0,
    INITVAL_3C = 0, INITVAL_3D = 0, INITVAL_3E = 0, INITVAL_3F = 0;
  localparam [64*320-1:0] INIT = {
    INITVAL_3F, INITVAL_3E, INITVAL_3D, INITVAL_3C,
    INITVAL_3B, INITVAL_3A, INITVAL_39, INITVAL_38,
    INITVAL_37, INITVAL_36, INITVAL_35, INITVAL_34,
    INITVAL_33, INITVAL_32, INITVAL_31, INITVAL_30,
    INITVAL_2F, INITVAL_2E, INITVAL_2D, INITVAL_2C,
    INITVAL_2B, INITVAL_2A, INITVAL_29, INITVAL_28,
    INITVAL_27, INITVAL_26, INITVAL_25, INITVAL_24,
    INITVAL_23, INITVAL_22, INITVAL_21, INITVAL_20,
    INITVAL_1F, INITVAL_1E, INITVAL_1D, INITVAL_1C,
    INITVAL_1B, INITVAL_1A, INITVAL_19, INITVAL_18,
    INITVAL_17, INITVAL_16, INITVAL_15, INITVAL_14,
    INITVAL_13, INITVAL_12, INITVAL_11, INITVAL_10,
    INITVAL_0F, INITVAL_0E, INITVAL_0D, INITVAL_0C,
    INITVAL_0B, INITVAL_0A, INITVAL_09, INITVAL_08,
    INITVAL_07, INITVAL_06, INITVAL_05, INITVAL_04,
    INITVAL_03, INITVAL_02, INITVAL_01, INITVAL_00};

  if (REGMODE_A != "NOREG" || REGMODE_B != "NOREG" || CLKAMUX != "CLKA" || CLKBMUX != "CLKB" ||
      CSDECODE_A != "0b000" || CSDECODE_B != "0b000") begin : gen_unknown
    $error("DP16KD: a mode that this model does not have");
  end

  wire [13:0] address_a = {ADA13, ADA12, ADA11, ADA10, ADA9, ADA8, ADA7, ADA6, ADA5, ADA4, ADA3, ADA2, ADA1, ADA0};
  wire [13:0] address_b = {ADB13, ADB12, ADB11, ADB10, ADB9, ADB8, ADB7, ADB6, ADB5, ADB4, ADB3, ADB2, ADB1, ADB0};
  wire [17:0] low_a = {DIA17, DIA16, DIA15, DIA14, DIA13, DIA12, DIA11, DIA10, DIA9, DIA8, DIA7, DIA6, DIA5, DIA4, DIA3, DIA2, DIA1, DIA0};
  wire [17:0] data_b = {DIB17, DIB16, DIB15, DIB14, DIB13, DIB12, DIB11, DIB10, DIB9, DIB8, DIB7, DIB6, DIB5, DIB4, DIB3, DIB2, DIB1, DIB0};
  wire [35:0] data_a = DATA_WIDTH_A == 36 ? {data_b, low_a} : {18'd0, low_a};
  wire write_a = CEA && WEA && !RSTA;
  wire write_b = CEB && WEB && !RSTB && DATA_WIDTH_A != 36;
  reg  [8:0] memory[0:2047];
  reg  [35:0] out_a, out_b;

  initial begin
    for (int n = 0; n < 1024; n++) {memory[2*n+1], memory[2*n]} = INIT[20*n+:18];
    out_a = 36'd0;
    out_b = 36'd0;
  end

  // The word of a port: as many memory from its address on, or bits of one unit.
  function automatic [35:0] word(input int width, input [13:0] address);
    word = 36'd0;
    case (width)
      36: for (int n = 0; n < 4; n++) word[9*n+:9] = memory[{address[13:5], 2'(n)}];
      18: for (int n = 0; n < 2; n++) word[9*n+:9] = memory[{address[13:4], 1'(n)}];
      9: word[8:0] = memory[address[13:3]];
      4: word[3:0] = memory[address[13:3]][{address[2], 2'b00}+:4];
      2: word[1:0] = memory[address[13:3]][{address[2:1], 1'b0}+:2];
      default: word[0] = memory[address[13:3]][address[2:0]];
    endcase
  endfunction

  // What is there when a port has written: its memory are the enabled ones.
  task automatic store(input int width, input [13:0] address, input [35:0] data);
    case (width)
      36: for (int n = 0; n < 4; n++) if (address[n]) memory[{address[13:5], 2'(n)}] = data[9*n+:9];
      18: for (int n = 0; n < 2; n++) if (address[n]) memory[{address[13:4], 1'(n)}] = data[9*n+:9];
      9: memory[address[13:3]] = data[8:0];
      4: memory[address[13:3]][{address[2], 2'b00}+:4] = data[3:0];
      2: memory[address[13:3]][{address[2:1], 1'b0}+:2] = data[1:0];
      default: memory[address[13:3]][address[2:0]] = data[0];
    endcase
  endtask

  // One block for both ports: each sees what was there before the clock. That of an unused port is tied to 0.
  wire clk = CLKA || CLKB;
  logic [35:0] before_a, before_b, after_a, after_b;
  always @(posedge clk) begin
    if (RESETMODE != "SYNC" && (RSTA || RSTB)) $fatal(1, "DP16KD: an asynchronous reset has no model");
    before_a = word(DATA_WIDTH_A, address_a);
    before_b = word(DATA_WIDTH_B, address_b);
    if (write_a) store(DATA_WIDTH_A, address_a, data_a);
    after_a = word(DATA_WIDTH_A, address_a);
    after_b = word(DATA_WIDTH_B, address_b);
    if (RSTA) out_a <= 36'd0;
    else if (CEA && !WEA) out_a <= before_a;
    else if (write_a && WRITEMODE_A == "WRITETHROUGH") out_a <= after_a;
    else if (write_a && WRITEMODE_A == "READBEFOREWRITE") out_a <= before_a;
    if (write_b) store(DATA_WIDTH_B, address_b, {18'd0, data_b});
    if (RSTB) out_b <= 36'd0;
    else if (CEB && !WEB) out_b <= before_b;
    else if (write_b && WRITEMODE_B == "WRITETHROUGH") out_b <= word(DATA_WIDTH_B, address_b);
    else if (write_b && WRITEMODE_B == "READBEFOREWRITE") out_b <= before_b;
    if (CEB && !WEB && !RSTB && write_a) out_b <= before_b ^ written(DATA_WIDTH_B, address_b, DATA_WIDTH_A, address_a);
    if (CEA && !WEA && !RSTA && write_b) out_a <= before_a ^ written(DATA_WIDTH_A, address_a, DATA_WIDTH_B, address_b);
  end

  // Bits of a port's word in the units that the other port writes, with its unit enables.
  function automatic [35:0] written(input int width, input [13:0] address, input int other, input [13:0] write);
    logic [10:0] unit;
    logic hit;
    written = 36'd0;
    for (int n = 0; n < (width == 36 ? 4 : width == 18 ? 2 : 1); n++) begin
      unit = width == 36 ? {address[13:5], 2'(n)} : width == 18 ? {address[13:4], 1'(n)} : address[13:3];
      case (other)
        36: hit = unit[10:2] == write[13:5] && write[unit[1:0]];
        18: hit = unit[10:1] == write[13:4] && write[unit[0]];
        default: hit = unit == write[13:3];
      endcase
      if (hit) written[9*n+:9] = 9'h1FF;
    end
  endfunction

  wire [35:0] read_b = DATA_WIDTH_B == 36 ? out_b : {out_b[17:0], 18'd0};
  assign {DOB17, DOB16, DOB15, DOB14, DOB13, DOB12, DOB11, DOB10, DOB9, DOB8, DOB7, DOB6, DOB5, DOB4, DOB3, DOB2, DOB1, DOB0} = read_b[35:18];
  assign {DOA17, DOA16, DOA15, DOA14, DOA13, DOA12, DOA11, DOA10, DOA9, DOA8, DOA7, DOA6, DOA5, DOA4, DOA3, DOA2, DOA1, DOA0} = DATA_WIDTH_B == 36 ? read_b[17:0] : out_a[17:0];
endmodule

// Product of 18 x 18 bits, signed or not.
module MULT18X18D (
    input A17, A16, A15, A14, A13, A12, A11, A10, A9, A8, A7, A6, A5, A4, A3, A2, A1, A0,
    input B17, B16, B15, B14, B13, B12, B11, B10, B9, B8, B7, B6, B5, B4, B3, B2, B1, B0,
    input C17, C16, C15, C14, C13, C12, C11, C10, C9, C8, C7, C6, C5, C4, C3, C2, C1, C0,
    input SIGNEDA, SIGNEDB, SOURCEA, SOURCEB,
    output P35, P34, P33, P32, P31, P30, P29, P28, P27, P26, P25, P24, P23, P22, P21, P20, P19, P18, P17, P16, P15, P14, P13, P12, P11, P10, P9, P8, P7, P6, P5, P4, P3, P2, P1, P0
);
  wire signed [18:0] a = {SIGNEDA && A17, A17, A16, A15, A14, A13, A12, A11, A10, A9, A8, A7, A6, A5, A4, A3, A2, A1, A0};
  wire signed [18:0] b = {SIGNEDB && B17, B17, B16, B15, B14, B13, B12, B11, B10, B9, B8, B7, B6, B5, B4, B3, B2, B1, B0};
  assign {P35, P34, P33, P32, P31, P30, P29, P28, P27, P26, P25, P24, P23, P22, P21, P20, P19, P18, P17, P16, P15, P14, P13, P12, P11, P10, P9, P8, P7, P6, P5, P4, P3, P2, P1, P0} = 36'(a * b);
endmodule
