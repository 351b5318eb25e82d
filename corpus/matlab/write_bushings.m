function write_bushings(deck, copy, ids, K)
%WRITE_BUSHINGS  Copies a deck with new stiffnesses.
%
%   write_bushings(deck, copy, ids, K) writes the file COPY: the lines of DECK, except that the lines `, K = ...` and
%   `, KT = ...` of BUSHING/ids(b) hold K(b, 1:3) and K(b, 4:6). Line ends stay as they are.

in = fopen(deck, 'r');
if in < 0
    error('write_bushings: cannot open %s', deck);
end
out = fopen(copy, 'w');
if out < 0
    error('write_bushings: cannot write %s', copy);
end
first = fread(in, 4096, 'uint8')';  % fgetl may or may not keep the carriage return of a Windows file
line_end = char(10);
if any(first == 13)
    line_end = char([13 10]);
end
fseek(in, 0, 'bof');
b = [];
line = fgetl(in);
while ischar(line)
    if ~isempty(line) && line(end) == char(13)
        line = line(1:end-1);
    end
    start = regexp(line, '^\s*[A-Za-z_]+/\d*', 'match', 'once');
    if ~isempty(start)
        [kind, id] = strtok(upper(strtrim(start)), '/');
        b = [];
        if strcmp(kind, 'BUSHING')
            b = find(ids == str2double(id(2:end)));
        end
    end
    if ~isempty(b) && ~isempty(regexp(line, '^\s*,\s*[Kk]\s*=', 'once'))
        fprintf(out, ', K = %.15g, %.15g, %.15g', K(b, 1:3));
    elseif ~isempty(b) && ~isempty(regexp(line, '^\s*,\s*[Kk][Tt]\s*=', 'once'))
        fprintf(out, ', KT = %.15g, %.15g, %.15g', K(b, 4:6));
    else
        fprintf(out, '%s', line);
    end
    fprintf(out, '%s', line_end);
    line = fgetl(in);
end
fclose(in);
fclose(out);
