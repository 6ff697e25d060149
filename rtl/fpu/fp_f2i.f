rtl/fpu/fp_pkg.sv
rtl/fpu/fp_shift_right.sv
rtl/fpu/fp_f2i.sv
