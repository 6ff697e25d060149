rtl/fpu/fp_pkg.sv
rtl/fpu/fp_lzc.sv
rtl/fpu/fp_round.sv
rtl/fpu/fp_pack.sv
rtl/fpu/fp_i2f.sv
