rtl/fpu/fp_pkg.sv
rtl/fpu/fp_product.sv
rtl/fpu/fp_lzc.sv
rtl/fpu/fp_fine_left.sv
rtl/fpu/fp_round.sv
rtl/fpu/fp_pack.sv
rtl/fpu/fp_fma.sv
