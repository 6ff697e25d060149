rtl/fpu/fp_pkg.sv
rtl/fpu/fp_normalise.sv
rtl/fpu/fp_select_sub.sv
rtl/fpu/fp_shift_right.sv
rtl/fpu/fp_round.sv
rtl/fpu/fp_pack.sv
rtl/fpu/fp_divsqrt.sv
