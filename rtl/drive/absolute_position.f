rtl/drive/absolute_position.sv
