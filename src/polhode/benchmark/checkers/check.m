function worst = check(top, file)
% Correct digits of a trajectory of the heavy top benchmark:  check('TOP.csv', 'MINE.csv')
%
% TOP.csv is a file of the benchmark; MINE.csv has the columns t, p, q, r, gamma1, gamma2, gamma3 in any
% order, and q0, q1, q2, q3 where the attitude is to be judged.  Decimals are taken exactly, from 10^9 to
% 10^-70.  Digits are -log10 of the larger of the error of omega, relative to the largest |omega| of
% TOP.csv, and the error of gamma; of the attitude -log10 of its error, of q or -q.  Errors are the
% largest of a component.  A missing time has 0 digits, bad input is an error.  Octave and MATLAB.
  tops = numbers(top);
  rows = numbers(file);
  omega = {'p', 'q', 'r'};
  gamma = {'gamma1', 'gamma2', 'gamma3'};
  attitude = {'q0', 'q1', 'q2', 'q3'};
  zero = zeros(1, 80);
  scale = 0;
  for n = 1:numel(tops)
    scale = max(scale, norm(cellfun(@(name) minus_of(tops{n}.(name), zero), omega)));
  end
  worst = 50;
  disp('t  state  attitude');
  for n = 1:numel(tops)
    row = tops{n};
    t = minus_of(row.t, zero);
    m = find(cellfun(@(one) abs(minus_of(one.t, row.t)) <= abs(t) / 1e9, rows), 1);
    if isempty(m)
      if t ~= 0
        fprintf('%g  missing\n', t);
        worst = 0;
      end
      continue
    end
    mine = rows{m};
    here = digits(max(largest(mine, row, omega, 1) / scale, largest(mine, row, gamma, 1)));
    if all(isfield(mine, attitude))
      off = min(largest(mine, row, attitude, 1), largest(mine, row, attitude, -1));
      here = [here, digits(off)];
    end
    fprintf('%g%s\n', t, sprintf('  %.2f', here));
    worst = min([worst, here]);
  end
  fprintf('worst %.2f correct digits\n', worst);
end

function off = largest(mine, row, names, sign)
  off = max(cellfun(@(name) abs(minus_of(sign * mine.(name), row.(name))), names));
end

function found = digits(off)
  found = min(50, max(0, -log10(off)));
end

function found = minus_of(a, b)
% The difference of two numbers given by their digits: exact until it is large.
  found = 0;
  for d = a - b
    found = 10 * found + d;
  end
  found = found * 1e-70;
end

function d = digits_of(text)
% The decimal digits of a number from 10^9 to 10^-70, with its sign.
  part = strsplit(lower(strtrim(text)), 'e');
  mantissa = part{1};
  power = 0;
  if numel(part) == 2
    power = str2double(part{2});
  end
  side = 1;
  if ~isempty(mantissa) && any(mantissa(1) == '+-')
    side = 1 - 2 * (mantissa(1) == '-');
    mantissa = mantissa(2:end);
  end
  whole = find([mantissa, '.'] == '.', 1) - 1;
  mantissa(mantissa == '.') = '';
  values = double(mantissa) - double('0');
  if isempty(values) || any(values < 0 | values > 9) || numel(part) > 2 || isnan(power)
    error('expected a number, not %s', text);
  end
  place = 10 - whole - power + (1:numel(values));
  if any(values(place < 1))
    error('expected a number below 1e10, not %s', text);
  end
  inside = place >= 1 & place <= 80;
  d = zeros(1, 80);
  d(place(inside)) = side * values(inside);
end

function rows = numbers(path)
% The rows of a file: structures of digits, by the names of the columns.
  lines = strsplit(strtrim(strrep(fileread(path), char(13), '')), char(10));
  names = strtrim(strsplit(lines{1}, ','));
  rows = cell(1, numel(lines) - 1);
  for n = 1:numel(rows)
    cells = strsplit(lines{n + 1}, ',');
    for k = 1:numel(names)
      rows{n}.(names{k}) = digits_of(cells{k});
    end
  end
end
