function crc = sbf_crc32(bytes)
% CRC-32 (zlib, polynomial 0xEDB88320 reflected) of four or more bytes (uint8), as a number.
%
% The register is linear in register and bytes, so the message is cut into columns of 32 bytes that are taken together,
% and the columns are joined two by two: register(A B) = Z register(A) xor register(B), Z = what as many zero bytes as B
% has do to the register. The start value 0xFFFFFFFF is that of inverting the first four bytes; zeros in front change
% nothing. 20 kB take about a millisecond; a loop over bytes takes that long for 500.
  persistent table shift
  if isempty(table)
    table = uint32(0:255);
    for k = 1:8
      table = bitxor(bitshift(table, -1), bitand(table, uint32(1)) * uint32(3988292384));
    end
    basis = bitshift(repmat(uint32(0:255), 4, 1), repmat([0; 8; 16; 24], 1, 256));
    for k = 1:32, basis = bitxor(bitshift(basis, -8), reshape(table(double(bitand(basis, uint32(255))) + 1), 4, 256)); end
    shift = {basis};  % row i: what 32 zero bytes make of byte i of the register
  end
  bytes = uint8(bytes(:));
  bytes(1:4) = bitcmp(bytes(1:4));
  columns = 2 ^ max(0, ceil(log2(numel(bytes) / 32)));
  block = reshape([zeros(32 * columns - numel(bytes), 1, 'uint8'); bytes], 32, columns);
  state = zeros(1, columns, 'uint32');
  for r = 1:32
    low = bitxor(uint8(bitand(state, uint32(255))), block(r, :));
    state = bitxor(bitshift(state, -8), table(double(low) + 1));
  end
  level = 1;
  while columns > 1
    if numel(shift) < level, shift{level} = apply(shift{level - 1}, shift{level - 1}); end
    state = bitxor(apply(shift{level}, state(1:2:end)), state(2:2:end));
    columns = columns / 2; level = level + 1;
  end
  crc = double(bitxor(state, uint32(4294967295)));
end

function after = apply(z, before)
  after = zeros(size(before), 'uint32');
  for k = 1:4
    part = double(bitand(bitshift(before, -8 * (k - 1)), uint32(255))) + 1;
    after = bitxor(after, reshape(z(k, part), size(before)));
  end
end
