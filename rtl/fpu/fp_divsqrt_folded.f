rtl/fpu/fp_pkg.sv
rtl/fpu/fp_normalise.sv
rtl/fpu/fp_round.sv
rtl/fpu/fp_pack.sv
rtl/fpu/fp_divsqrt_folded.sv
