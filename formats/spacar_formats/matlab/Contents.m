% spacar for MATLAB and Octave
%
% Analysis
%   spacar        - run an analysis (modes 0 to 10)
%   spacar_build  - build the MEX file of spacar
%
% Result files
%   getfrsbf      - value of a variable
%   loadsbd       - all variables of a .sbd result
%   loadsbm       - all variables of a .sbm result
%   getss         - state space system of an .ltv result
%   checksbf      - what is in a file, and whether it is sound
%   repinsbf      - replace the value of a variable
%   combsbd       - join .sbd results
%   mrltv         - modal reduction of an .ltv result
%   spacntrl      - proportional controller in an .ltv result
%
% Pictures and stresses
%   spavisual     - draw the mechanism
%   spadraw       - draw it with a slider for the time
%   stressbeam    - von Mises stress in beams
