rtl/fpu/fp_pkg.sv
rtl/fpu/fp_cmp.sv
