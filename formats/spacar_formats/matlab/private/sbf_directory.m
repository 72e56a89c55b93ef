function [d, fid, guard] = sbf_directory(file, anew)
% Open a result file and read what is in front of its steps (files.md section 8).
%
% d: file, kind ('sbd', 'sbm', 'ltv'), state (0 being written, 1 complete, 2 stopped early), committed, steps, data
% (first byte of the steps), stride, and for every variable a row of names, type (1 integer, 2 real, 3 text), rows, cols,
% offset (in the file; of a step variable in its step), isstep. fid is open as long as guard lives.
% The checksums of preamble and directory are verified when the directory is read. It is kept for the next call, and the
% 64 bytes of the preamble, with the checksum of the directory among them, tell whether the file is still that one; with
% ANEW it is read and verified in any case.
% Throws spacar:notFound, spacar:damaged.
  persistent known
  if isempty(known), known = struct('file', {}, 'preamble', {}, 'directory', {}); end
  [fid, reason] = fopen(file, 'r', 'ieee-le');
  if fid < 0, error('spacar:notFound', 'cannot open %s: %s', file, reason); end
  guard = onCleanup(@() fclose(fid));
  preamble = fread(fid, [1, 64], 'uint8=>uint8');
  if numel(preamble) < 64, damaged(file, sprintf('it has %d bytes, the preamble alone has 64', numel(preamble))); end
  state = double(preamble(14));
  preamble(14) = 0;  % the only byte that no checksum covers
  k = find(strcmp({known.file}, file), 1);
  if isempty(k), k = numel(known) + 1; end
  if nargin > 1 && anew || k > numel(known) || ~isequal(known(k).preamble, preamble)
    found = parse(fid, file, preamble, state);
    if numel(known) > 100, known = known([]); k = 1; end
    known(k) = struct('file', file, 'preamble', preamble, 'directory', found);
  end
  d = known(k).directory;
  d.state = state;
  fseek(fid, d.tdef + 24, 'bof');
  d.committed = fread(fid, 1, 'uint64');
  fseek(fid, 0, 'eof');
  d.bytes = ftell(fid);
  d.steps = min(d.committed, floor((d.bytes - d.data) / d.stride));
end

function d = parse(fid, file, preamble, state)
  if ~isequal(preamble(1:8), uint8([137 83 66 70 13 10 26 10]))
    error('spacar:damaged', '%s is not a SPACAR binary file', file);
  end
  major = double(typecast(preamble(9:10), 'uint16'));
  if major ~= 1, error('spacar:damaged', '%s has version %d of the format; version 1 is read', file, major); end
  if sbf_crc32(preamble(1:60)) ~= double(typecast(preamble(61:64), 'uint32'))
    damaged(file, 'wrong checksum of the preamble');
  end
  kinds = {'sbd', 'sbm', 'ltv'};
  q = double(typecast(preamble(17:56), 'uint64'));
  d = struct('file', file, 'kind', kinds{double(preamble(13))}, 'state', state, 'committed', 0, 'steps', 0, ...
             'bytes', 0, 'tdef', q(2), 'data', q(3), 'stride', q(4));
  fseek(fid, 64, 'bof');
  body = fread(fid, [1, d.data - 64], 'uint8=>uint8');
  if numel(body) < d.data - 64, damaged(file, 'it ends before its steps should begin'); end
  counted = body;
  counted(d.tdef - 64 + 24 + (1:8)) = 0;  % the number of steps changes while the file is written
  if sbf_crc32(counted) ~= double(typecast(preamble(57:60), 'uint32'))
    damaged(file, 'wrong checksum of the directory');
  end
  count = q(5); starts = []; at = 0;
  while at < d.tdef - 64
    starts(end + 1) = at;
    type = double(typecast(body(at + (17:20)), 'uint32'));
    size_ = double(typecast(body(at + (25:40)), 'uint64'));
    length_ = prod(size_);
    if type ~= 3, length_ = 8 * length_; end
    at = at + 48 + 8 * ceil(length_ / 8);
  end
  starts = [starts, d.tdef - 64 + 48 * (1:count)];
  records = body(bsxfun(@plus, starts', 1:48));
  n = numel(starts);
  d.names = cell(1, n);
  for k = 1:n, d.names{k} = char(records(k, [records(k, 1:16) > 0, false(1, 32)])); end
  words = double(reshape(typecast(reshape(records(:, 17:24)', 1, []), 'uint32'), 2, n));
  d.type = words(1, :);
  d.isstep = words(2, :) == 2;
  longs = double(reshape(typecast(reshape(records(:, 25:48)', 1, []), 'uint64'), 3, n));
  d.rows = longs(1, :); d.cols = longs(2, :); d.offset = longs(3, :);
end

function damaged(file, what)
  error('spacar:damaged', '%s is damaged: %s', file, what);
end
