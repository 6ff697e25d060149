// SPDX-License-Identifier: Apache-2.0
// debug_capture: what the channels of the scope saw last.
// Contract: a channel takes a word a clock after it is written, one of bank K two clocks after; a run that does
// not write it leaves it. `cycles` is taken when a run ends. From the second clock after ended_i on, word_o is
// that of channel_o, 0 to 7, one a clock; until then the core writes nothing of the next run.
//
// A word waits in a memory of its source, since a source writes one word a clock, in the slot of the lowest
// channel that takes it; each channel notes that slot. After the run the words go to the channels' own
// places, where those of later runs find them. Two kinds of channels can take one word: those that want this
// write of the run, and those that want the last one. The slot is then that of the first kind, which no later
// write of the run takes.
module debug_capture #(
    parameter int unsigned Channels = 8
) (
    input  logic                      clk_i,
    input  logic                      rst_ni,
    // writes of registers
    input  logic                      csr_write_i,
    input  logic [5:0]                csr_index_i,
    input  logic [31:0]               csr_data_i,
    // from the core
    input  logic                      run_start_i,
    input  logic                      ended_i,
    input  logic [31:0]               cycles_i,
    input  logic [3:0]                write_i,        // banks A, B, C, outputs
    input  logic [2:0][5:0]           write_index_i,
    input  logic [2:0][31:0]          write_data_i,
    // writes of bank K
    input  logic                      constant_write_i,
    input  logic [6:0]                constant_index_i,
    input  logic [31:0]               constant_data_i,
    // to the scope
    output logic [2:0]                channel_o,
    output logic [31:0]               word_o
);

  localparam int unsigned Sources = 4;  // bank A, bank B, bank C or outputs, bank K
  localparam logic [1:0] SourceC = 2'd2;
  localparam logic [1:0] SourceK = 2'd3;

  // ---- channels
  logic [1:0] kind, source;
  logic [Channels-1:0][6:0] index_q;
  logic [Channels-1:0][1:0] source_q;
  logic [Channels-1:0][3:0] one_from_q;  // source_q, a bit for each, of a channel that wants one write
  logic [Channels-1:0][3:0] last_from_q;  // .. that wants the last one
  logic [Channels-1:0] every_q;  // write of a run, the last one stays
  logic [Channels-1:0] is_output_q, is_cycles_q;
  logic [3:0] wanted;
  logic last;
  logic [Channels-1:0][3:0] wanted_q, count, count_q;
  logic [Channels-1:0] is_next_q;  // count_q is what is wanted
  logic [Channels-1:0][2:0] slot_q;
  logic [Channels-1:0] fresh_q;  // written since the channels' own places were
  logic [Channels-1:0] hit, hit_q;  // hit_q: with data_q
  logic [Channels-1:0] takes;
  // ---- sources
  logic constant_write_q;
  logic [6:0] constant_index_q;
  logic [31:0] constant_data_q;
  logic [Sources-1:0][31:0] data_q, waiting;
  logic [Sources-1:0][2:0] slot;
  // ---- after a run
  logic ended_q;
  logic [Channels-1:0] looks;  // the channel that is ahead
  logic [Channels-2:0] looked_q;
  logic walk_q;
  logic [2:0] channel_q, ahead;
  logic [2:0] from_slot_q;
  logic [1:0] from_source_q;
  logic from_fresh_q, from_cycles_q;
  logic [31:0] cycles_q;
  logic [31:0] own[0:Channels-1];

  // Numbers of writes are counted in the order of a shift register: 0, 3, 5, 8, .. 9 for the first to the 15th
  // write, then 1, where it stays: one table for two bits, no carry, cleared by the clock.
  function automatic logic [3:0] next_number(input logic [3:0] number);
    next_number = {number[2], number[1], !number[0], !((number[3] ^ number[2]) && number != 4'd9)};
  endfunction

  function automatic logic [3:0] number_of(input logic [3:0] write);  // of 1 to 15
    number_of = 4'd0;
    for (int n = 1; n < 16; n++) if (4'(n) < write) number_of = next_number(number_of);
  endfunction

  assign kind   = csr_data_i[debug_regmap_pkg::CHANNEL_KIND_LSB+:2];
  assign wanted = number_of(csr_data_i[debug_regmap_pkg::CHANNEL_WRITE_LSB+:4]);
  assign last   = csr_data_i[debug_regmap_pkg::CHANNEL_WRITE_LSB+:4] == 4'd0;

  always_comb begin
    case (kind)
      debug_regmap_pkg::CHANNEL_KIND_REGISTER:
        source = csr_data_i[debug_regmap_pkg::CHANNEL_BANK_LSB+:2];
      debug_regmap_pkg::CHANNEL_KIND_OUTPUT: source = SourceC;
      default: source = SourceK;
    endcase
  end

  // The bus is slow here, and nobody waits: a run starts, or the bus is held, a clock later at the earliest.
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) constant_write_q <= 1'b0;
    else constant_write_q <= constant_write_i;
  end

  always_ff @(posedge clk_i) begin
    constant_index_q <= constant_index_i;
    constant_data_q  <= constant_data_i;
    hit_q            <= hit;
    data_q           <= {constant_data_q, write_data_i};
  end

  genvar channel, s;
  generate
    for (channel = 0; channel < Channels; channel++) begin : gen_channel
      logic [5:0] index;
      logic write;

      always_ff @(posedge clk_i) begin
        if (csr_write_i && csr_index_i == debug_regmap_pkg::REG_CHANNEL + 6'(channel)) begin
          index_q[channel]     <= csr_data_i[debug_regmap_pkg::CHANNEL_INDEX_LSB+:7];
          source_q[channel]    <= source;
          one_from_q[channel]  <= last ? 4'd0 : 4'd1 << source;
          last_from_q[channel] <= last ? 4'd1 << source : 4'd0;
          is_output_q[channel] <= kind == debug_regmap_pkg::CHANNEL_KIND_OUTPUT;
          is_cycles_q[channel] <= kind == debug_regmap_pkg::CHANNEL_KIND_CYCLES;
          wanted_q[channel]    <= wanted;
          every_q[channel]     <= last;
        end
      end

      // Selections of two inputs: one table of six inputs a bit.
      assign index = source_q[channel][1] ? (source_q[channel][0] ? constant_index_q[5:0] : write_index_i[2]) :
                   source_q[channel][0] ? write_index_i[1] : write_index_i[0];
      assign write = source_q[channel][1] ?
                   (source_q[channel][0] ? constant_write_q && constant_index_q[6] == index_q[channel][6] :
                    is_output_q[channel] ? write_i[3] : write_i[2]) :
                   source_q[channel][0] ? write_i[1] : write_i[0];
      assign hit[channel] = write && index == index_q[channel][5:0];

      // Number of the next write of the run, and whether it is the one that is wanted.
      assign count[channel] = run_start_i ? 4'd0 : hit_q[channel] ? next_number(count_q[channel]) : count_q[channel];

      always_ff @(posedge clk_i) begin
        count_q[channel]   <= count[channel];
        is_next_q[channel] <= wanted_q[channel] == count[channel];
      end

      assign takes[channel] = hit_q[channel] && (every_q[channel] || is_next_q[channel]);

      always_ff @(posedge clk_i) if (takes[channel]) slot_q[channel] <= slot[source_q[channel]];

      always_ff @(posedge clk_i or negedge rst_ni) begin
        if (!rst_ni) fresh_q[channel] <= 1'b0;
        else if (takes[channel]) fresh_q[channel] <= 1'b1;
        else if (looks[channel]) fresh_q[channel] <= 1'b0;
      end
    end

    // ---- sources: the slot of the word in data_q
    for (s = 0; s < Sources; s++) begin : gen_source
      logic some_one, some_last;  // a channel takes it
      logic [2:0] slot_one, slot_last;

      always_comb begin
        some_one  = 1'b0;
        some_last = 1'b0;
        slot_one  = '0;
        slot_last = '0;
        for (int c = Channels - 1; c >= 0; c--) begin
          if (hit_q[c] && is_next_q[c] && one_from_q[c][s]) begin
            some_one = 1'b1;
            slot_one = 3'(c);
          end
          if (hit_q[c] && last_from_q[c][s]) begin
            some_last = 1'b1;
            slot_last = 3'(c);
          end
        end
      end

      assign slot[s] = some_one ? slot_one : slot_last;

      ram_lut #(
          .Words(Channels)
      ) u_ram (
          .clk_i,
          .write_i        (some_one || some_last),
          .write_address_i(slot[s]),
          .write_data_i   (data_q[s]),
          .read_address_i (from_slot_q),
          .read_data_o    (waiting[s])
      );
    end
  endgenerate

  // ---- after a run: where the word of the next channel is, then the word
  assign looks = {looked_q, ended_q};
  assign ahead = ended_q ? 3'd0 : channel_q + 3'd1;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      ended_q   <= 1'b0;
      looked_q  <= '0;
      walk_q    <= 1'b0;
      channel_q <= '0;
    end else begin
      ended_q  <= ended_i;
      looked_q <= looks[Channels-2:0];
      walk_q   <= |looks;
      if (|looks) channel_q <= ahead;
    end
  end

  always_ff @(posedge clk_i) begin
    from_slot_q   <= slot_q[ahead];
    from_source_q <= source_q[ahead];
    from_fresh_q  <= fresh_q[ahead];
    from_cycles_q <= is_cycles_q[ahead];
    // A new run clears the core's own before the last channel is recorded.
    if (ended_i) cycles_q <= cycles_i;
    if (walk_q) own[channel_q] <= word_o;
  end

  assign channel_o = channel_q;
  assign word_o    = from_cycles_q ? cycles_q :
                     from_fresh_q ? waiting[from_source_q] : own[channel_q];

  logic unused_bits;
  assign unused_bits = ^csr_data_i;

endmodule
