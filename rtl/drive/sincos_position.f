rtl/drive/sincos_position.sv
