function model = read_bushings(deck, ids)
%READ_BUSHINGS  The bushings of a deck and where their markers sit.
%
%   model = read_bushings(deck, ids) gives a structure array, one element per number in IDS:
%     .id, .name                   number and View name of the BUSHING
%     .I, .J                       its markers, each with
%       .part, .part_name          number and View name of the part ('' for ground)
%       .B                         4x4 operator [R p; 0 0 0 1] of the marker on its part
%
%   Reads what ADAMS/View writes: one argument per line, angles with the suffix D, `adams_view_name` comments before statements.

marker = struct('id', {}, 'part', {}, 'QP', {}, 'REULER', {});
bushing = struct('id', {}, 'name', {}, 'I', {}, 'J', {});
part_id = [];
part_name = {};
kind = '';
argument = '';
view_name = '';
in = fopen(deck, 'r');
if in < 0
    error('read_bushings: cannot open %s', deck);
end
fgetl(in);  % the title
line = fgetl(in);
while ischar(line)
    line = strtrim(line);  % the carriage return of a Windows file goes with the blanks
    named = regexp(line, '^!.*adams_view_name=''([^'']*)''', 'tokens', 'once');
    if ~isempty(named)
        view_name = named{1};
    end
    comment = find(line == '!');
    if ~isempty(comment)
        line = strtrim(line(1:comment(1)-1));
    end
    start = regexp(line, '^[A-Za-z_]+/\d*', 'match', 'once');
    if ~isempty(start)
        [kind, id] = strtok(upper(start), '/');
        id = str2double(id(2:end));
        line = strtrim(line(length(start)+1:end));
        argument = '';
        switch kind
            case 'PART'
                part_id(end+1) = id;
                part_name{end+1} = view_name;
                if isempty(view_name)
                    part_name{end} = sprintf('PART/%d', id);
                end
            case 'MARKER'
                marker(end+1) = struct('id', id, 'part', 0, 'QP', [0 0 0], 'REULER', [0 0 0]);
            case 'BUSHING'
                bushing(end+1) = struct('id', id, 'name', view_name, 'I', 0, 'J', 0);
        end
        view_name = '';
    end
    if any(strcmp(kind, {'PART', 'MARKER', 'BUSHING'})) && ~isempty(line)
        text = strtrim(line(1 + (line(1) == ','):end));
        assigned = regexp(text, '^[A-Za-z]+\s*=', 'match', 'once');
        if ~isempty(assigned)
            argument = upper(strtok(assigned, ' ='));
            text = text(length(assigned)+1:end);
        end
        if strcmp(kind, 'PART') && strcmpi(text, 'GROUND')
            part_name{end} = '';
        elseif strcmp(kind, 'MARKER') && any(strcmp(argument, {'QP', 'REULER'}))
            v = numbers(text);
            if isempty(assigned)
                v = [marker(end).(argument), v];  % the list goes on
            end
            marker(end).(argument) = v;
        elseif strcmp(kind, 'MARKER') && strcmp(argument, 'PART')
            marker(end).part = numbers(text);
        elseif strcmp(kind, 'BUSHING') && any(strcmp(argument, {'I', 'J'})) && ~isempty(assigned)
            bushing(end).(argument) = numbers(text);
        end
    end
    line = fgetl(in);
end
fclose(in);

for k = 1:length(ids)
    b = find([bushing.id] == ids(k));
    if length(b) ~= 1
        error('read_bushings: no BUSHING/%d in %s', ids(k), deck);
    end
    model(k).id = ids(k);
    model(k).name = bushing(b).name;
    model(k).I = place(bushing(b).I, marker, part_id, part_name);
    model(k).J = place(bushing(b).J, marker, part_id, part_name);
end

% -------------------------------------------------------------------------------------------------------------------------------
function m = place(id, marker, part_id, part_name)
k = find([marker.id] == id);
if length(k) ~= 1
    error('read_bushings: no MARKER/%d', id);
end
m.part = marker(k).part;
m.part_name = part_name{part_id == m.part};
m.B = [euler313(marker(k).REULER), marker(k).QP'; 0 0 0 1];

% -------------------------------------------------------------------------------------------------------------------------------
function v = numbers(text)
% A list such as "1.0, 90D, -3": the suffix D means degrees.
v = [];
while ~isempty(text)
    [word, text] = strtok(text, ', ');
    if isempty(word)
        break
    end
    if upper(word(end)) == 'D'
        v(end+1) = str2double(word(1:end-1))*pi/180;
    else
        v(end+1) = str2double(word);
    end
end
