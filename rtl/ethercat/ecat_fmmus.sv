// SPDX-License-Identifier: Apache-2.0
// ecat_fmmus: maps a byte of logical addresses through one FMMU a clock, bit by bit.
// Contract: window_o, read_o and write_o follow slot_i and address_i by three clocks. Of the logical byte window_o
// has the bits that FMMU slot_i maps, wherever they lie; nothing is mapped while the FMMU is not active.
module ecat_fmmus (
    input  logic clk_i,
    input  logic rst_ni,
    // registers
    input  ecat_pkg::register_access_t register_i,
    // a logical byte
    input  logic [2:0]  slot_i,
    input  logic [31:0] address_i,
    output logic        in_use_o,   // the FMMU of slot_i is active
    output ecat_pkg::window_t window_o,
    output logic        read_o,
    output logic        write_o
);

  // Bytes of an FMMU's registers; those before ACTIVATE are stored in columns.
  localparam logic [3:0] Start = 4'(esc_regmap_pkg::REG_FMMU_LOGICAL_START);
  localparam logic [3:0] Length = 4'(esc_regmap_pkg::REG_FMMU_LENGTH);
  localparam logic [3:0] FirstBit = 4'(esc_regmap_pkg::REG_FMMU_FIRST_BIT);
  localparam logic [3:0] LastBit = 4'(esc_regmap_pkg::REG_FMMU_LAST_BIT);
  localparam logic [3:0] Physical = 4'(esc_regmap_pkg::REG_FMMU_PHYSICAL_START);
  localparam logic [3:0] PhysicalBit = 4'(esc_regmap_pkg::REG_FMMU_PHYSICAL_BIT);
  localparam logic [3:0] Kind = 4'(esc_regmap_pkg::REG_FMMU_TYPE);
  localparam logic [3:0] Activate = 4'(esc_regmap_pkg::REG_FMMU_ACTIVATE);
  localparam int unsigned Columns = 32'(Activate);

  logic here;
  logic [ecat_pkg::FMMUS-1:0] active_q;
  logic [8*Columns-1:0] entry;
  logic [31:0] start;
  logic [15:0] length, physical;
  logic [2:0] bit_first, bit_last, physical_bit;
  logic [1:0] kind;

  assign here = register_i.write && register_i.address[11:7] == esc_regmap_pkg::REG_FMMU_LOGICAL_START[11:7];

  genvar c;
  generate
    for (c = 0; c < Columns; c++) begin : gen_column
      logic [7:0] column_q[0:ecat_pkg::FMMUS-1];
      always_ff @(posedge clk_i) begin
        if (here && register_i.address[3:0] == 4'(c)) column_q[register_i.address[6:4]] <= register_i.data;
      end
      assign entry[8*c+:8] = column_q[slot_i];
    end
  endgenerate

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) active_q <= '0;
    else if (here && register_i.address[3:0] == Activate) begin
      active_q[register_i.address[6:4]] <= register_i.data[esc_regmap_pkg::FMMU_ACTIVATE_ENABLE_LSB];
    end
  end

  assign start        = entry[8*Start+:32];
  assign length       = entry[8*Length+:16];
  assign bit_first    = entry[8*FirstBit+:3];
  assign bit_last     = entry[8*LastBit+:3];
  assign physical     = entry[8*Physical+:16];
  assign physical_bit = entry[8*PhysicalBit+:3];
  assign kind         = entry[8*Kind+:2];

  assign in_use_o = active_q[slot_i];

  // First clock: how far into the FMMU's range the byte lies.
  logic [31:0] distance_q;
  logic [15:0] length_q, physical_q;
  logic [2:0] bit_first_q, bit_last_q;
  logic signed [3:0] shift_q;
  logic [1:0] kind_q;
  logic active_now_q;
  always_ff @(posedge clk_i) begin
    distance_q   <= address_i - start;
    length_q     <= length;
    physical_q   <= physical;
    bit_first_q  <= bit_first;
    bit_last_q   <= bit_last;
    shift_q      <= {1'b0, physical_bit} - {1'b0, bit_first};
    kind_q       <= kind;
    active_now_q <= in_use_o;
  end

  // Second: which of its bits, and where those are.
  logic hit, begins, ends, behind, before_end;
  logic [15:0] past;
  logic [7:0] mask, mask_q, low_part, high_part;
  logic [15:0] spread, address_q;
  logic [2:0] shift_late_q;
  logic [1:0] kind_late_q;
  assign {before_end, past} = {1'b0, distance_q[15:0]} - {1'b0, length_q};
  assign hit     = active_now_q && distance_q[31:16] == '0 && before_end;
  assign begins  = distance_q[15:0] == '0;
  assign ends    = past == '1;
  assign mask    = (begins ? 8'hFF << bit_first_q : 8'hFF) & (ends ? 8'hFF >> (3'd7 - bit_last_q) : 8'hFF);
  // shift_q below 0: the byte begins in the one before, at bit 8 + shift_q.
  always_ff @(posedge clk_i) begin
    mask_q       <= hit ? mask : '0;
    shift_late_q <= shift_q[2:0];
    kind_late_q  <= kind_q;
    address_q    <= physical_q + distance_q[15:0] - {15'd0, shift_q[3]};
  end

  // Third: whether all of them lie in the byte after.
  assign spread = {8'd0, mask_q} << shift_late_q;
  assign {high_part, low_part} = spread;
  assign behind = low_part == '0 && high_part != '0;
  always_ff @(posedge clk_i) begin
    window_o.mask    <= mask_q;
    window_o.shift   <= shift_late_q;
    window_o.high    <= behind;
    window_o.address <= address_q + {15'd0, behind};
    read_o           <= mask_q != '0 && kind_late_q[esc_regmap_pkg::FMMU_TYPE_READ_LSB];
    write_o          <= mask_q != '0 && kind_late_q[esc_regmap_pkg::FMMU_TYPE_WRITE_LSB];
  end

  logic unused;
  assign unused = &{entry, register_i.read, register_i.application};

endmodule
